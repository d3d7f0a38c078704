// forefeel trace, and the notes of sessions and studies on a recorded motion.

#include "tests/support/executable.hpp"

namespace {

// 1 s at 5 mm/s along y, then 2 s of rest; 100 Hz, mm and ms, two pens, an orientation.
std::string recording() {
  std::string text = "# recorder 3\ntime pen px py pz qw qx qy qz\n";
  for (int i = 0; i <= 300; ++i) {
    const std::string t = std::to_string(10 * i), y = std::to_string(0.05 * std::min(i, 100));
    text += t + " A 1 " + y + " 0 1 0 0 0\n" + t + " B 900 " + y + " 0 1 0 0 0\n";
  }
  return text;
}

const std::string form = "rec.txt,columns=time/px/py/pz,unit=mm/ms,tool=A";

}  // namespace

TEST_CASE("trace checks a recording, changes it and writes it", "[trace]") {
  const BeamShop shop;
  shop.write("rec.txt", recording());
  const auto checked = shop.run("trace " + form + " --scene beam.toml --json");
  const auto json = json::parse(checked.out);
  CHECK(json["rows"] == 301);
  CHECK(json["seconds"] == Approx(3));
  CHECK(json["rate"] == Approx(100));
  CHECK(json["speed"]["max"] == Approx(0.005));
  CHECK(json["starts_pressed_in"] == true);
  CHECK(json["start"] == Approx(0.001));
  CHECK(json["rests"]["longest"] == Approx(2).margin(0.021));
  CHECK(json["orientation_ignored"] == true);
  CHECK(json["outside"]["share"].is_number());

  const auto written = shop.run("trace " + form + " --to-contact --from 0.2 --to 0.8 --rate 500 -o out.csv");
  const auto again = json::parse(shop.forefeel("trace out.csv --json").out);
  CHECK(again["rows"] == 301);
  CHECK(again["seconds"] == Approx(0.6));
  CHECK(again["start"] == 0.0);
  CHECK(again["box"][1][1] == Approx(0.003));
}

TEST_CASE("bad input of trace is refused", "[trace]") {
  const Workshop shop;
  shop.write("rec.txt", recording());
  shop.write("beam.toml", beam_scene());
  check_refused(shop, "trace rec.txt,columns=time/px/py/pz", {"several tools (pen)", "A, B"});
  check_refused(shop, "trace rec.txt", {"no column 't'", "time, pen, px"});
  check_refused(shop, "trace " + form + " --from 9 -o out.csv", {"--from"});
  check_refused(shop, "trace " + form + " --to-contact --offset 0,0,1 -o out.csv", {"--offset"});
  check_refused(shop, "trace " + form + " --rate 0 -o out.csv", {"--rate"});
  check_refused(shop, "trace " + form + " -o rec.txt", {"rec.txt"});
  check_refused(shop, "trace rec.txt,columns=a/b", {"columns is 'a/b'"});
  check_refused(shop, "trace rec.txt,unit=furlong", {"unit is 'furlong'"});
  check_refused(shop, "trace gone.csv", {"gone.csv"});
}

TEST_CASE("a session says what is unusual about its recorded motion", "[trace]") {
  const BeamShop shop;
  shop.write("rec.txt", recording());
  const auto run = shop.run("session beam.toml --clock virtual --device trace:" + form + " -o run --json");
  const auto json = json::parse(run.out);
  CHECK(json["seconds"] == Approx(3).margin(0.01));
  const std::string notes = json["notes"].dump();
  CHECK_THAT(notes, Contains("starts away from rest: its first position is 1 mm from it", "rests for",
                             "orientation is not used"));
}

TEST_CASE("a column of times beside a rate, and long gaps in time, are said", "[trace]") {
  const Workshop shop;
  shop.write("timed.csv",
             "t,x,y,z\n0,0,0,0\n0.01,0,0,0.001\n0.02,0,0,0.002\n0.52,0,0,0.003\n0.53,0,0,0.004\n");
  const auto plain = shop.run("trace timed.csv");
  CHECK_THAT(plain.out + plain.err,
             Contains("1 gaps in time, the longest 0.5 s") && !Contains("column of times is not used"));
  const auto rated = shop.run("trace timed.csv,columns=x/y/z,rate=100");
  CHECK_THAT(rated.out + rated.err, Contains("its column of times is not used: the rate gives the times") &&
                                        !Contains("gaps in time"));
}

TEST_CASE("a study takes a trace's own length, unless it gives one itself, and says what the trace is like",
          "[trace]") {
  const BeamShop shop("[session]\nseconds = 0.5\ncost = \"constant:0.01\"\n");
  shop.write("long.csv", "t,x,y,z\n0,0,0.002,0\n0.1,0,0.003,0\n0.8,0,0.003,0.001\n");
  const auto seconds = [&](const std::string& given) {
    shop.write("study.toml", "scene = \"beam.toml\"\nseeds = [1]\n" + given +
                                 "[vary]\npolicy = [\"nearest\"]\ndevice = [\"trace:long.csv\"]\n");
    const auto run = shop.run("study study.toml -o out" + std::to_string(given.size()) + " --json");
    CHECK_THAT(run.err, Contains("trace long.csv: starts away from rest: its first position is 2 mm"));
    return run.json()["devices"][0]["seconds"].get<double>();
  };
  CHECK(seconds("") == Approx(0.801));
  CHECK(seconds("[session]\nseconds = 0.3\n") == Approx(0.3));
}
