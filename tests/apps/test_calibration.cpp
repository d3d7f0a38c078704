// Calibration of labels, and spacing = "auto".

#include <fmt/format.h>

#include "scheduling/placement/auto_spacing.hpp"
#include "scheduling/study/calibration.hpp"
#include "tests/support/executable.hpp"

namespace {

// W = a/2 |x|^2 + b/4 |x|^4: a stiffening field, exact everywhere.
State field_state(const Vec3& x) {
  State s;
  s.at = x;
  s.force = -(40 + 2e4 * x.squaredNorm()) * x;
  s.stiffness = (40 + 2e4 * x.squaredNorm()) * Mat3::Identity() + 4e4 * x * x.transpose();
  s.solve.status = SolveStatus::converged;
  return s;
}

}  // namespace

TEST_CASE("labels are calibrated on a field that is known",
          "[calibration]" SLOW("evaluates every model at thousands of places")) {
  CalibrationOptions options;
  options.space.spacing = 0.006;
  options.space.box = {Vec3::Constant(-0.03), Vec3::Constant(0.03)};
  options.inward = Vec3(0.2, 0.1, 0.9);
  std::vector<State> pool, truth;
  for (const Vec3& x : lattice(options.space.box, 0.006)) pool.push_back(field_state(x));
  for (int i = 0; i < 24; ++i)
    truth.push_back(
        field_state(0.028 * Vec3(std::sin(2.1 * i), std::sin(3.7 * i + 1), std::sin(5.3 * i + 2))));
  options.threads = 1;
  const Calibration found = calibrate(pool, truth, options);
  REQUIRE(found.kinds.size() == 5);
  REQUIRE(found.table.size() == 20);
  for (const std::size_t positions : found.positions) CHECK(positions > 0);  // every label is met
  for (std::size_t kind = 0; kind < 5; ++kind) {
    CAPTURE(found.kinds[kind].name);
    const auto* cells = &found.table[4 * kind];
    std::size_t count = 0;
    for (int label = 0; label < 4; ++label) {
      count += cells[label].count;
      CHECK(cells[label].low <= cells[label].share);
      CHECK(cells[label].share <= cells[label].high);
      CHECK(cells[label].p50 <= cells[label].p95);
    }
    CHECK(count == truth.size() * found.sets.size());
    CHECK(cells[0].p95 < cells[3].p95);  // safe is safer than blank
    CHECK(cells[0].over == 0);
    CHECK(found.ranks[kind].label > 0.3);
    CHECK(found.ranks[kind].power > 0.3);
  }
  options.threads = 3;
  const Calibration again = calibrate(pool, truth, options);
  for (std::size_t i = 0; i < found.samples.size(); ++i) {
    CHECK(again.samples[i].error == found.samples[i].error);
    CHECK((again.samples[i].power == found.samples[i].power));
  }
}

TEST_CASE("calibration as a command", "[calibration]" SLOW("evaluates every model at thousands of places")) {
  const BeamShop shop;
  const auto outcome = shop.run(
      "classify --calibrate beam.toml --set 'state_space.box=[[-0.012,-0.012,-0.012],[0.012,0.012,0.012]]' "
      "--json -o out");
  const json found = outcome.json();
  CHECK(found["table"].size() == 20);
  CHECK(found["ranks"].size() == 5);
  for (const char* file : {"calibration.csv", "ranks.csv", "samples.csv", "report.html"})
    CHECK_THAT(shop.files(), Contains(std::string("out/") + file));
  shop.run("generate beam.toml -o soft.states --quiet --set material.young=4000");
  check_refused(shop, "classify soft.states --calibrate beam.toml -o other", {"soft.states", "material"});
}

TEST_CASE("the share that positions bound", "[calibration]") {
  CHECK(share_bound(0, 59, 0.95) == Approx(1 - std::pow(0.05, 1.0 / 59)));
  CHECK(share_bound(0, 58, 0.95) > 0.05);
  // scipy.stats.beta.ppf(0.95, k + 1, n - k)
  CHECK(share_bound(4, 200, 0.95) == Approx(0.045180414994718726).epsilon(1e-6));
  CHECK(share_bound(5, 200, 0.95) == Approx(0.05184333912029053).epsilon(1e-6));
  CHECK(share_bound(62, 1000, 0.99) == Approx(0.08204589697056867).epsilon(1e-6));
  CHECK(share_bound(7, 7, 0.95) == 1);
}

TEST_CASE("spacing = auto makes safe mean an error below the tolerance",
          "[calibration]" SLOW("solves lattices of several spacings")) {
  const Workshop shop;
  const std::string scene = R"([body]
phantom = "beam"
elements = 240
[material]
law = "neo-hookean"
young = 5000.0
poisson = 0.3
[state_space]
spacing = "auto"
box = [[-0.016, -0.016, -0.016], [0.016, 0.016, 0.016]]
)";
  shop.write("beam.toml", scene);
  const auto first = shop.run("generate beam.toml --json -o a.states");
  const json a = first.json();
  REQUIRE(a["spacing_auto"]["holds"] == true);
  CHECK(a["spacing"] == a["spacing_auto"]["spacing"]);
  CHECK(a["spacing_auto"]["safe"].get<int>() >= 59);  // fewer cannot bound a share by 5 %
  CHECK(a["spacing_auto"]["share_above_bound"].get<double>() <= 0.05);
  CHECK(a["spacing_auto"]["share_above"].get<double>() * a["spacing_auto"]["safe"].get<double>() ==
        Approx(a["spacing_auto"]["above"].get<double>()));
  CHECK_THAT(first.err, Contains("of 200 safe positions", "95 % confidence"));
  // The kept result does not depend on the number of threads, and equals the one computed without a cache.
  CHECK(shop.json("generate beam.toml --threads 1 -o b.states")["spacing"] == a["spacing"]);
  CHECK(shop.shell("export XDG_CACHE_HOME=$PWD/other; '" + executable() +
                   "' generate beam.toml --threads 1 --json -o c.states")
            .json()["spacing_auto"] == a["spacing_auto"]);
  // The kept file is checked.
  CHECK_THAT(shop.forefeel("generate beam.toml -o b.states").out, Contains("kept from before"));
  REQUIRE(shop.shell("sed -i 's/\"spacing\": 0.0/\"spacing\": 0.1/' ../cache/forefeel/*.spacing.json").code ==
          0);
  const Workshop::Outcome anew = shop.forefeel("generate beam.toml --json -o b.states");
  CHECK(anew.json()["spacing"] == a["spacing"]);
  CHECK_THAT(anew.err, Contains(".spacing.json: has a wrong checksum") && !Contains("kept from before"));
  CHECK_THAT(shop.forefeel("generate beam.toml -o b.states").out, Contains("kept from before"));
  // A finer tolerance never takes a coarser lattice.
  const json fine = shop.json("generate beam.toml --set state_space.tolerance=0.0005 -o d.states");
  CHECK(fine["spacing"].get<double>() < a["spacing"].get<double>());
  REQUIRE(fine["spacing_auto"]["holds"] == true);
  // The claim is tested at other random positions: at most a twentieth of the safe ones is above the tolerance.
  std::string points = "x,y,z\n";
  for (int i = 1; i <= 400; ++i)
    points += fmt::format("{},{},{}\n", 0.016 * std::sin(2.1 * i), 0.016 * std::sin(3.7 * i + 1),
                          0.016 * std::sin(5.3 * i + 2));
  shop.write("points.csv", points);
  const json labels = shop.json("evaluate d.states --points points.csv");
  const json truth = shop.json("solve beam.toml --points points.csv --quiet --set state_space.spacing=0.004");
  std::size_t safe = 0, above = 0;
  for (std::size_t i = 0; i < 400; ++i) {
    if (labels["labels"][i] != "safe") continue;
    const std::vector<double> f = labels["forces"][i], t = truth["states"][i]["force"];
    const double error =
        std::hypot(f[0] - t[0], f[1] - t[1], f[2] - t[2]) / std::max(std::hypot(t[0], t[1], t[2]), 0.05);
    ++safe;
    above += error > 0.0005 ? 1 : 0;
  }
  CHECK(safe > 200);
  CHECK(static_cast<double>(above) <= 0.05 * static_cast<double>(safe));
  // A tolerance that no spacing reaches: the states are written, and the answer is negative.
  const Workshop::Outcome never = shop.forefeel(
      "generate beam.toml --json --set state_space.tolerance=1e-9 --set "
      "'state_space.box=[[-0.016,-0.016,-0.016],[0.016,0,0]]' -o never.states");
  INFO(never.err);
  CHECK(never.code == 1);
  CHECK(never.json()["spacing_auto"]["holds"] == false);
  CHECK(never.json()["spacing_auto"]["share_above_bound"].get<double>() > 0.05);
  CHECK(never.json()["states"].get<int>() > 100);
  CHECK_THAT(never.err, Contains("no spacing that was tried"));
  CHECK_THAT(shop.files(), Contains("never.states"));
  const Workshop::Outcome info = shop.forefeel("info a.states");
  CHECK_THAT(info.out, Contains("spacing \"auto\""));
  shop.run("solve beam.toml --at=0,0,0.001");
  const auto session = shop.run("session beam.toml --clock virtual --seconds 0.2 --json -o run");
  CHECK(session.json()["spacing"] == a["spacing"]);
  check_refused(shop, "solve beam.toml --at=0,0,0 --set state_space.spacing=automatic", {"auto"});
  check_refused(shop, "solve beam.toml --at=0,0,0 --set state_space.tolerance=0", {"tolerance", "above 0"});
}

TEST_CASE("rank correlation and intervals of a share", "[calibration]") {
  CHECK(rank_correlation({1, 2, 3, 4}, {10, 20, 30, 1e9}) == Approx(1));
  CHECK(rank_correlation({1, 2, 3, 4}, {4, 3, 2, 1}) == Approx(-1));
  CHECK(rank_correlation({1, 2, std::nan(""), 4}, {1, 2, 9, INFINITY}) == Approx(1));
  // scipy.stats.spearmanr([1, 2, 2, 3, 5], [2, 1, 4, 3, 3])
  CHECK(rank_correlation({1, 2, 2, 3, 5}, {2, 1, 4, 3, 3}) == Approx(0.36842105263157904));
  CHECK(std::isnan(rank_correlation({1, 1, 1}, {1, 2, 3})));
  // statsmodels proportion_confint(3, 20, method="wilson")
  CHECK(wilson_interval(3, 20).low == Approx(0.0523687).epsilon(1e-5));
  CHECK(wilson_interval(3, 20).high == Approx(0.3604189).epsilon(1e-5));
  CHECK(wilson_interval(0, 50).low == 0);
  CHECK(wilson_interval(50, 50).high == 1);
}

TEST_CASE("calibrations that cannot be run", "[calibration]") {
  const BeamShop shop;
  check_refused(shop, "classify --calibrate absent.toml", {"absent.toml"});
  check_refused(shop, "classify --calibrate beam.toml --grid 0.01", {"--calibrate"});
  check_refused(shop, "classify absent.states --calibrate beam.toml", {"absent.states"});
}
