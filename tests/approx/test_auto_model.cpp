// The model that evaluate chooses by leaving out groups: compared with SciPy's kernels on measured forces,
// the error that it expects against the true one, and the groups themselves.

#include <iomanip>

#include "approx/error/left_out.hpp"
#include "approx/measured/position_groups.hpp"
#include "approx/methods/evaluate.hpp"
#include "geometry/common/quantiles.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

namespace {

// Known forces, and places with their true force.
struct Case {
  std::vector<State> known;
  std::vector<Vec3> points, truth;
  void add(bool held, const Vec3& at, const Vec3& force) {
    if (held) {
      points.push_back(at);
      truth.push_back(force);
    } else {
      State state;
      state.at = at;
      state.force = force;
      known.push_back(state);
    }
  }
};

// A probe pressed into a curved organ at 73 places 10 to 20 mm apart, to ten depths 1 mm apart: forces up to
// 5 N with the noise of a sensor. Every fourth place is held back.
Case probed(unsigned seed, double noise) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-0.0025, 0.0025);
  std::normal_distribution<double> sensor(0, noise);
  Case result;
  for (int place = 0; place < 73; ++place) {
    const double x = 0.015 * (place / 9 - 4) + jitter(random), y = 0.015 * (place % 9 - 4) + jitter(random);
    const double top = 0.01 * std::cos(20 * x) * std::cos(15 * y);
    const double stiff = 1 + 0.5 * std::sin(40 * x + 1) * std::cos(30 * y);
    for (int step = 1; step <= 10; ++step) {
      const double depth = 0.001 * step, f = stiff * (130 * depth + 1.7e4 * depth * depth);
      const Vec3 force(0.1 * f * std::sin(30 * y), 0.1 * f * std::cos(25 * x), f);
      result.add(place % 4 == 3, Vec3(x, y, top - depth),
                 force + Vec3(sensor(random), sensor(random), sensor(random)));
    }
  }
  return result;
}

// Scattered places in a smooth field. dense: share of them within a few millimetres of one place.
Case scattered(unsigned seed, int known, double noise, double dense = 0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.03, 0.03);
  std::normal_distribution<double> sensor(0, noise), close(0, 0.003);
  Case result;
  for (int i = 0; i < known + 150; ++i) {
    Vec3 at(place(random), place(random), place(random));
    const bool held = i >= known;
    if (!held && i < dense * known) at = Vec3(0.01 + close(random), 0.01 + close(random), close(random));
    const Vec3 error =
        held || noise == 0 ? Vec3(Vec3::Zero()) : Vec3(sensor(random), sensor(random), sensor(random));
    result.add(held, at, field_state(at).force + error);
  }
  return result;
}

// The same case, but the forces to compare with also have the noise of the sensor.
Case measured(Case given, unsigned seed, double noise) {
  std::mt19937 random(seed + 1000);
  std::normal_distribution<double> sensor(0, noise);
  for (Vec3& force : given.truth) force += Vec3(sensor(random), sensor(random), sensor(random));
  return given;
}

std::vector<double> errors(const Evaluation& found, const Case& given) {
  std::vector<double> out;
  for (std::size_t i = 0; i < given.truth.size(); ++i)
    out.push_back((found.made.forces[i] - given.truth[i]).norm());
  return out;
}

double best_of_scipy(const Case& given) {
  const TemporaryFolder folder;
  const auto file = [&](const char* name) { return (folder / name).string(); };
  {
    std::ofstream states(file("states.csv")), points(file("points.csv"));
    states << std::setprecision(17);
    points << std::setprecision(17);
    const auto row = [](std::ofstream& out, const Vec3& at, const Vec3& f) {
      out << at[0] << ',' << at[1] << ',' << at[2] << ',' << f[0] << ',' << f[1] << ',' << f[2] << '\n';
    };
    for (const State& s : given.known) row(states, s.at, s.force);
    for (std::size_t i = 0; i < given.points.size(); ++i) row(points, given.points[i], given.truth[i]);
  }
  const std::string script = (source_folder() / "tests/approx/scipy_best.py").string();
  const std::string command = "OPENBLAS_NUM_THREADS=1 /usr/bin/python3 '" + script + "' " +
                              file("states.csv") + " " + file("points.csv") + " " + file("best.txt");
  REQUIRE(std::system(command.c_str()) == 0);
  std::ifstream in(file("best.txt"));
  double best = HUGE_VAL;
  int kernels = 0;
  for (double p95 = 0; in >> p95; ++kernels) best = std::min(best, p95);
  REQUIRE(kernels >= 8);
  return best;
}

}  // namespace

TEST_CASE("the chosen model is no worse than the best of SciPy's kernels, and its error is as expected",
          "[auto][scipy]" SLOW("compares with SciPy, which only run.sh all installs")) {
  if (!has_python_module("scipy.interpolate")) return skip("python3-scipy is not installed");
  const std::vector<std::pair<std::string, Case>> cases{{"probed", probed(1, 0.03)},
                                                        {"probed, noisy", probed(5, 0.1)},
                                                        {"scattered", scattered(2, 200, 0)},
                                                        {"scattered, noisy", scattered(3, 250, 0.02)}};
  for (const auto& [name, given] : cases) {
    const Evaluation found = evaluate(given.known, given.points, {});
    REQUIRE(found.chosen);
    const double p95 = quantile_of(errors(found, given), 0.95, QuantileRule::linear),  // as numpy.quantile
        best = best_of_scipy(given);
    CAPTURE(name, p95, best, forefeel::name(found.options.model.kernel), found.options.model.neighbours,
            found.options.model.ridge, found.chosen->p95);
    CHECK(p95 <= (1 + 1e-6) * best);
    CHECK(found.chosen->p50 < found.chosen->p95);
  }
}

TEST_CASE("the expected error is that of unseen places: scattered, clustered, noisy and along probes",
          "[auto]" SLOW("chooses a model of many sets")) {
  const std::vector<std::pair<std::string, std::function<Case(unsigned)>>> kinds{
      {"scattered", [](unsigned seed) { return scattered(seed, 200, 0); }},
      {"scattered, noisy", [](unsigned seed) { return measured(scattered(seed, 200, 0.02), seed, 0.02); }},
      {"half of it dense", [](unsigned seed) { return scattered(seed, 240, 0, 0.5); }},
      {"probed", [](unsigned seed) { return probed(seed, 0.03); }}};
  for (const auto& [name, make] : kinds) {
    std::vector<double> ratios;
    for (const unsigned seed : {11u, 12u, 13u}) {
      if (name == "probed" && seed > 11) continue;  // 550 states
      const Case given = make(seed);
      const Evaluation found = evaluate(given.known, given.points, {});
      REQUIRE(found.chosen);
      ratios.push_back(found.chosen->p95 / quantile_of(errors(found, given), 0.95));
    }
    CAPTURE(name, ratios);
    CHECK(median(ratios) > 1 / 1.5);
    CHECK(median(ratios) < 1.5);
    for (const double ratio : ratios) CHECK((ratio > 0.4 && ratio < 2.5));
  }
}

TEST_CASE(
    "places farther from the states than any force left out are counted; the choice shows how far it is",
    "[auto]") {
  const Case given = scattered(4, 120, 0.01);
  std::vector<Vec3> points(given.points.begin(), given.points.begin() + 20);
  for (const double far : {0.2, 0.3, 0.4}) points.emplace_back(far, 0, 0);
  std::vector<double> shares;
  const Evaluation found =
      evaluate(given.known, points, {.show = [&](std::string_view what, double share) {
                 if (what.find("model") != std::string_view::npos && std::isfinite(share))
                   shares.push_back(share);
               }});
  REQUIRE(found.chosen);
  CHECK(found.chosen->beyond == 3);
  REQUIRE(!shares.empty());
  CHECK(std::ranges::is_sorted(shares));
  CHECK((shares.front() > 0 && shares.back() <= 1));
}

TEST_CASE("probes to ten depths are groups of their own; a lattice falls into compact ones", "[auto]") {
  const Case given = probed(1, 0.03);
  std::vector<Vec3> at;
  for (const State& s : given.known) at.push_back(s.at);
  const PositionGroups probes = position_groups(at);
  CHECK(probes.natural);
  CHECK(probes.count == 55);
  for (std::size_t i = 0; i < at.size(); ++i) CHECK(probes.of[i] == probes.of[i / 10 * 10]);
  const std::vector<Vec3> lattice = lattice_points(3, 0.006);
  const PositionGroups blocks = position_groups(lattice);
  CHECK_FALSE(blocks.natural);
  std::vector<std::size_t> size(blocks.count, 0);
  for (const std::uint32_t group : blocks.of) ++size.at(group);
  for (const std::size_t n : size) CHECK((n >= 2 && n <= 4));
  const std::vector<std::uint32_t> part = spread_over_parts(at, probes, 8);
  CHECK(std::set(part.begin(), part.end()).size() == 8);
  for (const std::uint32_t p : {0u, 7u}) CHECK(std::ranges::count(part, p) >= 6);
}

TEST_CASE("the choice is the same each time, keeps what is given, and few states leave it open", "[auto]") {
  const Case given = scattered(4, 120, 0.01);
  const Evaluation once = evaluate(given.known, given.points, {}),
                   again = evaluate(given.known, given.points, {});
  for (std::size_t i = 0; i < given.points.size(); ++i) CHECK(once.made.forces[i] == again.made.forces[i]);
  const Evaluation fixed = evaluate(
      given.known, given.points,
      {.choose = true,
       .model = {.kernel = Kernel::linear, .neighbours = 30, .select = Select::label, .ridge = 0.01}});
  REQUIRE(fixed.chosen);
  CHECK(fixed.options.model.kernel == Kernel::linear);
  CHECK(fixed.options.model.neighbours == 30);
  CHECK(fixed.options.model.select == Select::label);
  CHECK(fixed.options.model.ridge == 0.01);
  CHECK(std::isfinite(fixed.chosen->p95));
  CHECK_FALSE(evaluate(given.known, given.points, {.model = {.kernel = Kernel::cubic}})
                  .chosen);  // as it was asked for
  CHECK_FALSE(
      evaluate(states_at(lattice_points(1, 0.006)), given.points, {}).chosen);  // states with stiffness
  const Evaluation few = evaluate(std::span(given.known).first(5), given.points, {});
  REQUIRE(few.chosen);
  CHECK(std::isnan(few.chosen->p95));
  for (const Vec3& force : few.made.forces) CHECK(force.allFinite());
}

TEST_CASE("of many states some patches are left out, and the error is as expected",
          "[auto]" SLOW("chooses a model of thousands of states")) {
  const Case given = scattered(6, 4000, 0.01);
  const AutoModel chosen =
      choose_model(given.known, {.model = {.kernel = Kernel::cubic, .neighbours = 40}, .spacing = 0.004}, {});
  CHECK(chosen.positions >= 100);
  CHECK(chosen.positions <= 600);
  const Evaluation made = evaluate(given.known, given.points,
                                   {.model = {.kernel = Kernel::cubic,
                                              .neighbours = 40,
                                              .select = chosen.model.select,
                                              .ridge = chosen.model.ridge},
                                    .spacing = 0.004});
  const double p95 = quantile_of(errors(made, given), 0.95);
  CHECK(p95 < 0.05);
  CHECK(chosen.p95 > 0.5 * p95);
  CHECK(chosen.p95 < 5 * p95);
}

TEST_CASE(
    "states that contradict each other at one position are averaged, and the largest difference is told",
    "[auto]") {
  std::vector<Vec3> at = lattice_points(1, 0.01), force;
  for (const Vec3& x : at) force.push_back(-100 * x);
  const std::vector<State> once = measured_states(at, force);
  std::vector<State> repeated = once;
  for (const double error : {0.3, -0.1, -0.2}) {  // their sum is 0, so the mean of all four is the first
    repeated.push_back(once[5]);
    repeated.back().force.x() += error;
  }
  const std::vector<Vec3> points{{0.003, 0.002, 0.001}, once[5].at};
  const EvaluateOptions cubic{.model = {.kernel = Kernel::cubic}};
  const Evaluation plain = evaluate(once, points, cubic), mean = evaluate(repeated, points, cubic);
  CHECK(plain.repeated.averaged == 0);
  CHECK(mean.repeated.averaged == 1);
  CHECK(mean.repeated.contradicting == 3);
  CHECK(mean.repeated.largest_difference == Approx(0.5));
  CHECK(mean.states == once.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    CHECK((mean.made.forces[i] - plain.made.forces[i]).norm() < 1e-9);
  CHECK_THROWS_AS(measured_states(at, std::span(force).first(3)), InputError);
}

// A recording of a winding path: no state lies as far from the rest as such a place does from all.
TEST_CASE("States are left out however far the wanted places are",
          "[auto]" SLOW("chooses a model of many sets")) {
  std::vector<Vec3> at, forces;
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.01 * i;
    at.emplace_back(0.05 * std::sin(t), 0.05 * std::cos(0.9 * t), 0.01 * std::sin(0.3 * t));
    forces.emplace_back(at.back().x(), 1, -at.back().z());
  }
  const std::vector<State> states = measured_states(at, forces);
  for (const double away : {0.001, 0.005, 0.01, 0.02, 0.03, 0.05, 0.1}) {
    const std::vector<SeenPlace> wanted{{.away = away, .beyond = -0.001, .from = Vec3(0, 0, away)}};
    CAPTURE(away);
    CHECK(leave_out(states, wanted, 0.005).groups >= 3);
  }
}
