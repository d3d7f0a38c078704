// Sessions of the command: documented keys, the same bits again, replays, interrupts, recorded costs, reports.

#include "tests/apps/contract.hpp"
#include "tests/support/session_keys.hpp"

TEST_CASE("session", "[contract]") {
  const BeamShop shop;
  for (const std::string clock : {"virtual", "real"}) {
    const json summary = shop.json("session beam.toml --clock " + clock +
                                   " --seconds 0.5 --device path:press,speed=0.02 -o " + clock);
    check_keys(summary, forefeel::session_summary_keys);
    check_keys(summary, {"error.by_label", "provenance.command", "provenance.version", "provenance.commit",
                         "provenance.scene_hash", "provenance.libraries", "provenance.machine"});
    CHECK(summary["clock"] == clock);
    const int frames = summary["frames"].get<int>() + summary["loop"]["skipped"].get<int>();
    CHECK(frames >= 499);
    CHECK(frames <= 501 + summary["loop"]["ending_frames"].get<int>());
    for (const char* file : {"summary.json", "frames.csv", "dispatch.csv", "switches.csv", "report.html"})
      CHECK_THAT(shop.files(), Contains(clock + "/" + file));
    CHECK_THAT(shop.read(clock + "/frames.csv"), Catch::StartsWith("t,x,y,z,fx,fy,fz,label,model,known"));
    CHECK_THAT(shop.read(clock + "/dispatch.csv"),
               Catch::StartsWith(
                   "id,x,y,z,label,priority,requested,started,finished,first_used,status,worker,parent"));
  }
}

TEST_CASE("a virtual session is the same bits again, whatever the threads", "[contract]") {
  const BeamShop shop;
  const std::string arguments =
      "session beam.toml --clock virtual --seconds 0.4 --device path:circle,tremor=1e-4 --quiet --seed 7 ";
  shop.run(arguments + "--threads 1 -o one");
  shop.run(arguments + "--threads 2 -o two");
  for (const std::string file : {"frames.csv", "dispatch.csv", "switches.csv"})
    CHECK(shop.same("one/" + file, "two/" + file));
}

TEST_CASE(
    "a run is not written over the one it replays, and states that arrive have the label of their place",
    "[contract]") {
  const BeamShop shop;
  shop.write("arrivals.csv", "t,x,y,z\n0.1,0,0,0.006\n0.05,0,0,0\n");  // in any order
  shop.run(
      "session beam.toml --clock virtual --seconds 0.3 --device path:press,speed=0.02 "
      "--arrivals arrivals.csv -o run --quiet");
  const std::string frames = shop.read("run/frames.csv");
  const std::string dispatch = shop.shell("cut -d, -f2-5,11 run/dispatch.csv").out;
  CHECK_THAT(dispatch, Contains("0,0,0,blank,arrived", "0,0,0.006,sparse,arrived"));
  check_refused(shop, "session beam.toml --clock virtual --seconds 0.1 --replay run -o ./run",
                {"expected another folder"});
  CHECK(shop.read("run/frames.csv") == frames);
}

TEST_CASE("a replay names the run as its device, and ends where that ended", "[contract]") {
  const BeamShop shop;
  shop.run("session beam.toml --clock virtual --seconds 0.3 --device path:press,speed=0.02 -o run --quiet");
  const json replayed = shop.json("session beam.toml --clock virtual --replay run -o again");
  CHECK(replayed["device"] == "replay:run");
  CHECK(replayed["interrupted"] == false);
  CHECK(replayed["frames_asked"] == 300);
  CHECK(replayed["frames"] == 300);
  CHECK(shop.shell("cut -d, -f1-4 run/frames.csv > a; cut -d, -f1-4 again/frames.csv > b; cmp a b").code ==
        0);
}

TEST_CASE("an empty value does not pass for an option that is not there", "[contract]") {
  const BeamShop shop;
  check_refused(shop, "generate beam.toml --error '' -o s.states", {"--error", "is empty"});
  for (const char* option :
       {"--seconds", "--workers", "--latency", "--policy", "--device", "--states", "--seed", "--threads"})
    check_refused(shop, std::string("session beam.toml --clock virtual -o run ") + option + " ''", {option});
}

TEST_CASE("what a session cannot run with is named with its place", "[contract]") {
  const BeamShop shop("[session]\nlatency = 1e9\n");
  shop.write("far.csv", "t,x,y,z\n0.1,0,0,0.006\n0.2,0,0,0.7\n");
  const std::string session = "session beam.toml --clock virtual --seconds 0.1 -o run ";
  check_refused(shop, session, {"beam.toml: session.latency: is 1000000000"});
  check_refused(shop, session + "--latency 1e8", {"--latency: is 100000000"});
  check_refused(shop, session + "--set session.latency=1e7", {"--set session.latency: is 10000000"});
  shop.write("plain.toml", beam_scene());
  check_refused(shop, "session plain.toml --clock virtual --seconds 0.1 -o run --arrivals far.csv",
                {"far.csv:3: is 0.7 m from rest"});
  const std::string many = "--set model.neighbours=100000 --set state_space.spacing=0.0002 ";
  check_refused(shop, session + "--latency 0 " + many, {"--set model.neighbours: is 100000", "GB"});
  check_refused(shop, "generate beam.toml --error 0.1 -o s.states " + many,
                {"model.neighbours: is 100000", "GB"});
}

TEST_CASE("options of solving are reported as ignored where states arrive at given times", "[contract]") {
  const Workshop shop;
  int runs = 0;
  const auto said = [&](std::string command, const std::vector<std::string>& parts) {
    command.replace(command.rfind("-o run"), 6, "-o run" + std::to_string(++runs));
    const auto outcome = shop.run(command);
    CHECK(outcome.error_lines() == 1);
    for (const std::string& part : parts) CHECK_THAT(outcome.err, Contains(part));
  };
  shop.write("good.csv", "t,x,y,z\n0.1,0,0,0\n");
  shop.write("beam.toml", beam_scene());
  shop.write("others.toml", beam_scene("[session]\nworkers = 3\npreempt = false\n"));
  shop.write("both.toml", beam_scene("[session]\nrest_first = true\narrivals = \"good.csv\"\n"));
  shop.write("alone.toml", beam_scene("[session]\narrivals = \"good.csv\"\n"));
  const std::string more = " --clock virtual --seconds 0.1 --quiet -o ",
                    given = "session beam.toml --arrivals good.csv" + more;
  for (const char* option :
       {"--workers 2", "--cost paper", "--latency 0.1", "--policy fifo", "--predictor kalman"})
    said(given + "run " + option,
         {std::string(option).substr(0, std::string(option).find(' ')) + ": without effect", "--arrivals"});
  for (const char* key :
       {"preempt=true", "placement=path", "rest_first=false", "first_guess=false", "batch=4"})
    said(given + "run --set session." + key,
         {"--set session." + std::string(key).substr(0, std::string(key).find('=')) + ": without effect"});
  said("session both.toml" + more + "run",
       {"both.toml:12: session.rest_first: without effect", "both.toml:13: session.arrivals"});
  said("session alone.toml --workers 3" + more + "run",
       {"--workers: without effect", "alone.toml:12: session.arrivals"});
  said("session others.toml --arrivals good.csv" + more + "run",
       {"others.toml:13: session.preempt, others.toml:12: session.workers: without effect", "--arrivals"});
  const auto plain = shop.run(given + "plain --switch none --set session.update_travel=0.5");
  CHECK(plain.err.empty());
}

TEST_CASE("a replay says which options it leaves without effect", "[contract]") {
  const BeamShop shop;
  shop.run("session beam.toml --clock virtual --seconds 0.2 --device path:press,speed=0.02 -o run --quiet");
  const std::string replay = "session beam.toml --clock virtual --replay run --quiet -o ";
  const auto plain = shop.run(replay + "plain");
  CHECK(plain.err.empty());
  const auto said = shop.run(replay + "vain --policy nearest --workers 5 --cost constant:0.5 --latency 0.2");
  CHECK(said.error_lines() == 1);
  CHECK_THAT(said.err, Contains("--policy, --workers, --cost, --latency: without effect with --replay"));
  CHECK(shop.same("plain/frames.csv", "vain/frames.csv"));
  const Workshop::Outcome set = shop.forefeel(replay + "set --set session.preempt=false");
  CHECK_THAT(set.err, Contains("--set session.preempt: without effect with --replay"));
  const Workshop::Outcome moved =
      shop.forefeel(replay + "moved --device path:circle --predictor constant-velocity --switch none");
  CHECK_THAT(moved.err, Contains("--device, --predictor: without effect") && !Contains("--switch"));
}

TEST_CASE("two commands on one cache: both give what one gives, and what they solved is kept", "[contract]") {
  const BeamShop shop;
  const std::string session = executable() +
                              " session beam.toml --clock virtual --device "
                              "path:circle,speed=0.03 --quiet --seconds ";
  const auto same = [&](const std::string& a, const std::string& b) {
    for (const std::string file : {"/frames.csv", "/dispatch.csv", "/states.csv"})
      CHECK(shop.same(a + file, b + file));
  };
  REQUIRE(
      shop.shell(session + "0.5 -o one & p=$!; " + session + "0.5 -o two; r=$?; wait $p && exit $r").code ==
      0);
  same("one", "two");

  // The cache is locked during the whole command: missing references are solved for this command alone.
  if (!has_command("flock")) return skip("flock is not installed");
  REQUIRE(shop.shell("rm -r ../cache; " + session + "0.1 -o begun").code == 0);
  const auto notes_of = [&](const std::string& run) {
    return json::parse(shop.read(run + "/summary.json"))["notes"].dump();
  };
  CHECK_THAT(notes_of("begun"), !Contains("only read"));
  REQUIRE(
      shop.shell("flock -n $(find ../cache -name '*.states')-lock -c '" + session + "0.5 -o held'").code ==
      0);
  CHECK_THAT(notes_of("held"), Contains("only read"));
  same("one", "held");
  REQUIRE(shop.shell(session + "0.5 -o after").code == 0);
  CHECK_THAT(notes_of("after"), !Contains("only read"));
  same("one", "after");
}

TEST_CASE("a session that is interrupted writes what it has", "[contract]") {
  const BeamShop shop;
  // The signal comes when its first states and frames are on disk.
  const Workshop::Outcome outcome =
      run_interrupted(shop, "session beam.toml --clock real --seconds 600 --device path:circle -o run",
                      "[ -s run/session.states-wal ] && " + is_larger("run/session.inputs"), 0);
  const auto frames = outcome.json()["frames"].get<std::size_t>();
  CHECK(frames > 0);
  CHECK(frames < 600000);
  CHECK_THAT(outcome.json()["notes"].dump(), Contains("interrupted"));
  CHECK(outcome.json()["frames_asked"] == 600000);
  const auto skipped = outcome.json()["loop"]["skipped"].get<std::size_t>();
  CHECK(outcome.json()["seconds"] == Approx(1e-3 * double(frames + skipped)));
  CHECK(outcome.json()["loop"]["last_force"] == 0);
  CHECK(outcome.error_lines() == 1);
  CHECK_THAT(outcome.err, Contains("interrupted after " + std::to_string(frames) + " of 600000 frames"));
  CHECK_THAT(shop.files(), Contains("run/frames.csv", "run/report.html"));
}

TEST_CASE("a fill that is interrupted says so, with what it has", "[contract]") {
  const BeamShop shop;
  const Workshop::Outcome outcome = run_interrupted(
      shop,
      "generate beam.toml -o s.states --set 'state_space.box=[[-0.02,-0.02,-0.02],[0.02,0.02,0.02]]' "
      "--set state_space.spacing=0.001 --threads 1",
      "[ -s s.states-wal ]", 0.3);
  CHECK(outcome.json()["solved"].get<int>() > 0);
  CHECK(outcome.json()["solved"].get<int>() < 68921);
  CHECK_THAT(outcome.err, Contains("rerun the same command to resume"));
}

TEST_CASE("a session that is interrupted while it rehearses says so and writes what it has", "[contract]") {
  const BeamShop shop;
  // Solves of 1 s are too slow for this motion, so that no schedule is perfect and all of them are rehearsed.
  const Workshop::Outcome outcome =
      run_interrupted(shop,
                      "session beam.toml --clock virtual --policy clairvoyant "
                      "--seconds 300 --cost constant:1 --device path:circle,speed=0.05 -o run",
                      "[ -d run ]", 0.5);
  // A simulated schedule is never reported as the session.
  CHECK(outcome.json()["frames"] == 0);
  CHECK(outcome.json()["frames_asked"] == 300000);
  CHECK(outcome.json()["seconds"] == 0);
  CHECK(outcome.json()["states"]["solved"] == 0);
  CHECK(outcome.json()["policy"] == "clairvoyant");
  CHECK_THAT(outcome.json()["notes"].dump(), Contains("interrupted while simulating schedule"));
  CHECK(outcome.error_lines() == 1);
  CHECK_THAT(outcome.err, Contains("interrupted while simulating schedule", "0 of 300000 frames"));
  CHECK(outcome.json()["prediction"].contains("kalman"));
  CHECK_THAT(shop.files(), Contains("run/report.html"));
  for (const char* file : {"run/frames.csv", "run/dispatch.csv"})
    CHECK(std::ranges::count(shop.read(file), '\n') == 1);  // only the header
  CHECK(shop.json("info run/session.states")["states"] == 0);
}

TEST_CASE("costs that were recorded are kept, and a damaged file of them is made anew", "[contract]") {
  const BeamShop shop;
  const std::string session = "session beam.toml --clock virtual --seconds 0.1 --cost recorded --quiet -o ";
  const std::string lines = "wc -l < $(find ../cache -name '*[0-9a-f].costs.csv')";
  shop.run(session + "one");
  const std::string kept = shop.shell("cat $(find ../cache -name '*.costs.csv')").out;
  CHECK(kept.starts_with("seconds\n"));
  CHECK(std::stoi(shop.shell(lines).out) > 40);
  shop.run(session + "two");
  CHECK(shop.shell("cat $(find ../cache -name '*.costs.csv')").out == kept);
  CHECK(shop.same("one/dispatch.csv", "two/dispatch.csv"));
  for (const std::string damage : {"seconds\n0.01\nnone\n", "", "x"}) {
    REQUIRE(shop.shell("printf '" + damage + "' > $(find ../cache -name '*.costs.csv')").code == 0);
    const auto again = shop.run(session + "again");
    CHECK_THAT(again.err, !Contains("csv:"));
    CHECK(std::stoi(shop.shell(lines).out) > 40);
  }
}

TEST_CASE("a report stands on its own", "[contract]") {
  const BeamShop shop;
  const std::string arguments =
      "session beam.toml --clock virtual --seconds 0.3 --device path:press,speed=0.02 --quiet ";
  shop.run(arguments + "-o run");
  const std::string report = shop.read("run/report.html");
  CHECK(report.starts_with("<!DOCTYPE html>"));
  CHECK(report.ends_with("</html>\n"));
  for (const char* outside : {"src=", "href=\"http", "@import", "url(http", "<script src", "<link"})
    CHECK_THAT(report, !Contains(outside));
  for (const char* part : {"first visits", "Provenance", "frames_over_jnd"})
    CHECK_THAT(report, Contains(part));
  if (!has_command("gnuplot"))
    skip("gnuplot is not installed");
  else
    CHECK_THAT(report, Contains("<svg", "</svg>"));
  // Without gnuplot the report is still written and says that plots are missing.
  const std::string without = "PATH=/nowhere '" + executable() + "' " + arguments + "-o bare";
  REQUIRE(shop.shell(without).code == 0);
  CHECK_THAT(shop.read("bare/report.html"), Contains("Plots need gnuplot") && !Contains("<svg"));
}

TEST_CASE("--quiet says nothing and --json keeps stdout to itself", "[contract]") {
  const BeamShop shop;
  const auto quiet = shop.run("generate beam.toml -o quiet.states --quiet");
  CHECK(quiet.out.empty());
  CHECK(quiet.err.empty());
  CHECK_THAT(shop.forefeel("solve beam.toml --at=0,0,0.002 --quiet").out,
             Contains("0.002"));  // --quiet still shows results
  const Workshop::Outcome overridden = shop.forefeel(
      "solve beam.toml --at=0,0,0.002 --json --set material.young=10000 --set body.elements=240");
  const Workshop::Outcome plain = shop.forefeel("solve beam.toml --at=0,0,0.002 --json");
  const double twice = overridden.json()["states"][0]["force"][2],
               once = plain.json()["states"][0]["force"][2];
  CHECK(twice == Approx(2 * once).epsilon(1e-8));  // the force is proportional to Young's modulus
}
