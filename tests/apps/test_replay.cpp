// forefeel replay: the command's words and exit codes, of runs that went to their end, were interrupted or killed.

#include "contract.hpp"

namespace {

const std::string viscous = "[[material.viscosity]]\nshare = 0.3\ntime = 0.05\n";

}  // namespace

TEST_CASE("real and virtual runs replay to the same bits by the command", "[replay]") {
  const BeamShop shop;
  shop.write(
      "viscous.toml",
      "[body]\nphantom = \"beam\"\nelements = 240\n[[material]]\nlaw = \"neo-hookean\"\nyoung = 5000.0\n"
      "poisson = 0.3\n" +
          viscous +
          "[state_space]\nspacing = 0.004\nbox = [[-0.004, -0.004, -0.004], [0.004, 0.004, 0.004]]\n");
  for (const std::string session :
       {"beam.toml --clock real --seconds 1.5", "viscous.toml --clock real --seconds 1",
        "beam.toml --clock virtual --seconds 3",
        "viscous.toml --clock virtual --seconds 2 --set model.data=jet --cost constant:0.05"}) {
    CAPTURE(session);
    const json run = shop.json("session " + session + " -o run");
    const json replay = shop.json("replay run");
    CHECK(replay["frames"] == run["frames"]);
    CHECK(replay["equal"] == run["frames"]);
    CHECK(replay["first_difference"].is_null());
    CHECK(replay["whole"] == true);
    CHECK(replay["recorded_by"] == replay["replayed_by"]);
    const auto words = shop.run("replay run");
    const std::string frames = std::to_string(run["frames"].get<int>());
    CHECK_THAT(words.out, Catch::StartsWith(frames + " of " + frames + " frames equal"));
    CHECK_THAT(words.out, Contains("forces in " + frames + " rows of frames.csv"));
    CHECK(words.err.empty());
  }
}

TEST_CASE("interrupted and killed runs replay as far as they came",
          "[replay]" SLOW("runs sessions in real time")) {
  const BeamShop shop;
  const json cut = run_interrupted(shop, "session beam.toml --clock real --seconds 600 -o cut",
                                   is_larger("cut/session.inputs"), 1)
                       .json();
  const json replay = shop.json("replay cut");
  CHECK(replay["equal"] == cut["frames"]);
  CHECK(replay["whole"] == true);

  shop.shell(
      executable() + " session beam.toml --clock real --seconds 600 -o killed >/dev/null 2>&1 & p=$!; " +
      wait_until("[ -s killed/session.states-wal ] && " + is_larger("killed/session.inputs", 100'000)) +
      "kill -9 $p; wait $p");
  CHECK(!shop.has("killed/summary.json"));
  const Workshop::Outcome killed = shop.forefeel("replay killed --json");
  INFO(killed.err);
  CHECK(killed.code == 1);
  CHECK(killed.json()["whole"] == false);
  CHECK(killed.json()["frames"] > 200);
  CHECK(killed.json()["equal"] == killed.json()["frames"]);
  CHECK_THAT(killed.err, Contains("ends early, because the run was killed or its disk was full"));
}

TEST_CASE("a changed record is a difference, a damaged or missing one is refused in one line", "[replay]") {
  const BeamShop shop;
  const json run = shop.json("session beam.toml --clock virtual --seconds 0.5 -o run");
  REQUIRE(run["frames"] == 500);
  // The last record is the end, 5 bytes; the one before is a frame, whose last 24 bytes are the force sent.
  shop.shell(
      "cp -r run changed; size=$(stat -c %s run/session.inputs); printf '\\125' | dd "
      "of=changed/session.inputs "
      "bs=1 conv=notrunc seek=$((size - 6)) 2>/dev/null");
  const Workshop::Outcome changed = shop.forefeel("replay changed");
  INFO(changed.err);
  CHECK(changed.code == 1);
  CHECK_THAT(changed.out, Catch::StartsWith("499 of 500 frames equal") &&
                              Contains("first difference in frame 499 (0.499 s), sent force: "));
  const Workshop::Outcome document = shop.forefeel("replay changed --json");
  CHECK(document.code == 1);
  CHECK(document.json()["first_difference"]["frame"] == 499);
  CHECK(document.json()["first_difference"]["force"] == "sent");

  shop.shell(
      "cp -r run damaged; size=$(stat -c %s run/session.inputs); printf 'Q' | dd of=damaged/session.inputs "
      "bs=1 "
      "conv=notrunc seek=$((size - 5)) 2>/dev/null");
  check_refused(shop, "replay damaged",
                {"damaged/session.inputs", "is damaged at byte", "no record of a run"});
  shop.shell("rm damaged/session.inputs");
  check_refused(shop, "replay damaged", {"damaged/session.inputs", "no such file", "session.record"});
  check_refused(shop, "replay nowhere", {"nowhere", "no such folder"});

  // The table of another run beside the record, or one with more frames.
  shop.json("session beam.toml --clock virtual --seconds 0.5 --set session.seed=2 -o other");
  shop.shell(
      "cp -r run mixed; cp other/frames.csv mixed; cp -r run longer; tail -n 1 run/frames.csv >> "
      "longer/frames.csv");
  check_refused(shop, "replay mixed", {"mixed/frames.csv:", "is not that of session.inputs", "of one run"});
  check_refused(shop, "replay longer", {"longer/frames.csv:502", "holds 500 frames, the table 501"});
  shop.shell("rm mixed/frames.csv");
  CHECK_THAT(shop.forefeel("replay mixed").out, Contains("session.inputs alone"));

  shop.json("session beam.toml --clock virtual --seconds 0.2 --set session.record=false -o without");
  CHECK(!shop.has("without/session.inputs"));
}
