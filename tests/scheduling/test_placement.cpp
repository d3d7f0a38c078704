// Placement by estimated error, on a beam of a few tetrahedra made by code; truth by tight solves.

#include "scheduling/placement/candidate_errors.hpp"
#include "scheduling/placement/placement.hpp"

#include <Eigen/LU>
#include <stop_token>

#include "scheduling/motion/random.hpp"
#include "small_body.hpp"

namespace {

PlacementOptions options_of(const SessionInput& input, double error) {
  PlacementOptions options;
  options.error = error;
  options.space = input.touched.space;
  options.truth_samples = 40;
  options.threads = 1;
  return options;
}

struct Placed {
  std::vector<State> states;
  PlacementReport report;
};

Placed place(const SessionInput& input, const PlacementOptions& options,
             const std::vector<State>& known = {}) {
  Placed placed{.states = known, .report = {}};
  placed.report = place_states(
      input.touched.body, options, known, [&](State s) { placed.states.push_back(std::move(s)); },
      [](const PlacementProgress&) {});
  return placed;
}

Vec3 random_in(const Box& box, std::uint64_t key) {
  return box.low + box.size().cwiseProduct(Vec3(random::uniform(random::mix(key, 1)),
                                                random::uniform(random::mix(key, 2)),
                                                random::uniform(random::mix(key, 3))));
}

std::vector<State> truth_of(const SessionInput& input, std::size_t count, std::uint64_t seed) {
  Solver solver(input.touched.body);
  std::vector<State> truth;
  for (std::size_t i = 0; i < count; ++i)
    truth.push_back(
        solver
            .reference(random_in(input.touched.space.box, random::mix(seed, i)), input.touched.space.spacing)
            .state);
  return truth;
}

bool same_positions(const std::vector<State>& a, const std::vector<State>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].at != b[i].at || a[i].force != b[i].force) return false;
  return true;
}

}  // namespace

TEST_CASE("the energy interpolant reproduces a quartic energy and meets its data", "[placement]") {
  // W = x^4 / a^2 + 3 x y^2 z / a^2 + x^2 z / a + z^2, a = 1 cm: f = -grad W, K its second derivatives.
  const double a = 0.01;
  const auto at = [&](const Vec3& p) {
    const double x = p.x(), y = p.y(), z = p.z();
    State s;
    s.at = p;
    s.force = -Vec3(4 * x * x * x / (a * a) + 3 * y * y * z / (a * a) + 2 * x * z / a,
                    6 * x * y * z / (a * a), 3 * x * y * y / (a * a) + x * x / a + 2 * z);
    s.stiffness << 12 * x * x / (a * a) + 2 * z / a, 6 * y * z / (a * a), 3 * y * y / (a * a) + 2 * x / a,
        6 * y * z / (a * a), 6 * x * z / (a * a), 6 * x * y / (a * a), 3 * y * y / (a * a) + 2 * x / a,
        6 * x * y / (a * a), 2;
    s.solve.status = SolveStatus::converged;
    return s;
  };
  std::vector<State> states;
  for (std::uint64_t i = 0; i < 7; ++i)
    states.push_back(at(random_in({Vec3::Constant(-a), Vec3::Constant(a)}, random::mix(3, i))));
  std::vector<const State*> pointers;
  for (const State& s : states) pointers.push_back(&s);

  const auto quartic = EnergyInterpolant::fit(pointers, 4);
  REQUIRE(quartic);
  for (std::uint64_t i = 0; i < 50; ++i) {
    const Vec3 x = random_in({Vec3::Constant(-2 * a), Vec3::Constant(2 * a)}, random::mix(4, i));
    CHECK((quartic->force(x) - at(x).force).norm() < 1e-8);
  }
  const auto cubic = EnergyInterpolant::fit(pointers, 3);  // cannot be exact, but meets force and stiffness
  REQUIRE(cubic);
  for (const State& s : states) {
    CHECK((cubic->force(s.at) - s.force).norm() < 1e-9);
    const double step = 1e-6;
    for (int j = 0; j < 3; ++j) {
      const Vec3 up = cubic->force(s.at + step * Vec3::Unit(j)),
                 down = cubic->force(s.at - step * Vec3::Unit(j));
      CHECK(((down - up) / (2 * step) - s.stiffness.col(j)).norm() < 1e-5);
    }
  }
  pointers.resize(3);  // 27 numbers do not determine 34 terms
  CHECK_FALSE(EnergyInterpolant::fit(pointers, 4));
  states[1].stiffness.setConstant(unknown);
  CHECK_FALSE(EnergyInterpolant::fit(pointers, 3));
}

TEST_CASE("a placed set holds its error, with few states, and says what it is", "[placement]") {
  const SessionInput input = small_input();
  std::size_t last = 0;
  for (const double error : {0.05, 0.01, 0.003}) {
    const Placed placed = place(input, options_of(input, error));
    CAPTURE(error, placed.states.size(), placed.report.estimate.p95, placed.report.truth.error.p95);
    REQUIRE(placed.report.estimate_holds);
    REQUIRE(placed.report.truth.holds);
    CHECK(placed.report.estimate.held() <= error);
    CHECK(placed.states.size() >= last);  // a smaller error never takes fewer
    CHECK(placed.states.size() <= 60);    // the lattice has 125
    last = placed.states.size();

    StateSpace space(input.touched.space);
    for (const State& s : placed.states) {
      CHECK(s.usable());
      CHECK(space.insert(s).is_new);  // none twice
    }
    ErrorEstimator estimator(space, {});
    const std::vector<State> truth = truth_of(input, 100, 17);  // a sample that the placement has not seen
    const ErrorQuantiles really = true_error(estimator, truth, 0.05);
    CHECK(really.p95 <= error);
    CHECK(really.max <= 2 * error);
    CHECK(placed.report.truth.on_surface > 0);
    // Also where the model extrapolates: corners, and middles of edges and faces.
    Solver solver(input.touched.body);
    for (int part = 0; part < 27; ++part) {
      const Vec3 share(part % 3, part / 3 % 3, part / 9);
      const Vec3 at = input.touched.space.box.low + 0.5 * input.touched.space.box.size().cwiseProduct(share);
      const State s = solver.reference(at, input.touched.space.spacing).state;
      CHECK((estimator.force(at) - s.force).norm() <= 2 * error * std::max(s.force.norm(), 0.05));
    }
    // Quantiles of the true error exceed those of the estimate by at most a half, on the same sample.
    std::vector<double> estimates;
    for (const State& s : truth) estimates.push_back(estimator(s.at));
    std::sort(estimates.begin(), estimates.end());
    CHECK(1.5 * estimates[95] >= really.p95);
    CHECK(1.5 * estimates[50] >= really.p50);
  }
}

TEST_CASE("placing does not depend on threads, and goes on where it was cut", "[placement]") {
  const SessionInput input = small_input();
  PlacementOptions options = options_of(input, 0.005);
  const Placed whole = place(input, options);
  REQUIRE(whole.report.estimate_holds);
  options.threads = 2;
  const Placed parallel = place(input, options);
  CHECK(same_positions(whole.states, parallel.states));
  CHECK(whole.report.truth.error.p95 == parallel.report.truth.error.p95);
  CHECK(whole.report.truth.error.max == parallel.report.truth.error.max);

  for (const std::size_t cut :
       {std::size_t{1}, std::size_t{3}, whole.states.size() - 1, whole.states.size()}) {
    const std::vector<State> known(whole.states.begin(),
                                   whole.states.begin() + static_cast<std::ptrdiff_t>(cut));
    const Placed resumed = place(input, options, known);
    CAPTURE(cut);
    CHECK(resumed.report.resumed == cut);
    CHECK(resumed.report.solved == whole.states.size() - cut);
    CHECK(same_positions(whole.states, resumed.states));
  }
}

TEST_CASE("a linear body takes three solves", "[placement]") {
  const SessionInput input = small_input(Law::linear);
  const Placed placed = place(input, options_of(input, 1e-6));
  CHECK(placed.report.linear);
  CHECK(placed.report.solved == 3);
  CHECK(placed.states.size() == 3);
  CHECK(placed.report.truth.holds);
  CHECK(placed.report.truth.error.max < 1e-9);
  CHECK(place(input, options_of(input, 1e-6), placed.states).report.solved == 0);
}

TEST_CASE("placing stops at its limits and says so", "[placement]") {
  const SessionInput input = small_input();
  PlacementOptions options = options_of(input, 1e-7);
  options.max_states = 12;
  const Placed limited = place(input, options);
  CHECK(limited.states.size() == 12);
  CHECK(limited.report.most_states == 12);
  CHECK_FALSE(limited.report.estimate_holds);
  CHECK(limited.report.truth.solved == 0);

  std::stop_source stop;
  options.stop = stop.get_token();
  std::size_t seen = 0;
  const PlacementReport report = place_states(
      input.touched.body, options, {},
      [&](State) {
        if (++seen == 4) stop.request_stop();
      },
      [](const PlacementProgress&) {});
  CHECK(seen == 4);
  CHECK(report.stopped);
  CHECK(report.states == 4);
}

TEST_CASE("a truth that is cut says what was not solved, and counts none of it as failed", "[placement]") {
  const SessionInput input = small_input();
  const PlacementOptions whole = options_of(input, 0.05);
  std::stop_source stop;
  PlacementOptions options = whole;
  options.stop = stop.get_token();
  const PlacementReport report = place_states(
      input.touched.body, options, {}, [](const State&) {},
      [&](const PlacementProgress& p) {
        if (p.truth_done == 10) stop.request_stop();
      });
  CHECK(report.stopped);
  CHECK(report.truth.samples == 10);
  CHECK(report.truth.failed == 0);
  CHECK(report.truth.solved == 10);
  CHECK(report.truth.unsolved >= 30);
  CHECK(report.truth.error.p95 > 0);
  CHECK(place(input, whole).report.truth.unsolved == 0);
}

TEST_CASE("the next position on-line is the worst of the candidates by weight", "[placement]") {
  const SessionInput input = small_input();
  StateSpace space(input.touched.space);
  ErrorEstimator estimator(space, {});
  const std::vector<Vec3> far_and_near{{0.012, 0, 0}, {0.003, 0, 0}, {0, 0, 0}};
  const std::vector<double> even{1, 1, 1};
  CHECK(std::isinf(estimator(far_and_near[0])));
  REQUIRE(worst_position(estimator, space, far_and_near, even));

  Solver solver(input.touched.body);
  space.insert(solver.reference(Vec3::Zero(), 0.006).state);
  CHECK(worst_position(estimator, space, far_and_near, even)->index ==
        0);  // by distance, while nothing can be said
  CHECK(worst_position(estimator, space, far_and_near, std::vector<double>{0, 1, 1})->index == 1);
  CHECK_FALSE(worst_position(estimator, space, far_and_near, std::vector<double>{0, 0, 1}));  // known

  for (const State& s : place(input, options_of(input, 0.02)).states) space.insert(s);
  std::vector<Vec3> candidates;
  for (std::uint64_t i = 0; i < 60; ++i)
    candidates.push_back(random_in(input.touched.space.box, random::mix(5, i)));
  std::vector<double> weights(candidates.size());
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = 0.5 + random::uniform(random::mix(6, i));
  const auto worst = worst_position(estimator, space, candidates, weights);
  REQUIRE(worst);
  REQUIRE(std::isfinite(worst->estimate));
  for (std::size_t i = 0; i < candidates.size(); ++i)
    CHECK(weights[i] * estimator(candidates[i]) <= weights[worst->index] * worst->estimate * (1 + 1e-9));
  // Solving there makes the estimate there vanish.
  space.insert(solver.reference(candidates[worst->index], 0.006).state);
  CHECK(estimator(candidates[worst->index]) < 0.01 * worst->estimate);
}

TEST_CASE("the worst candidate is found without judging those that cannot win", "[placement]") {
  // A field that stiffens, with a lump of 6 mm beside its middle.
  const Vec3 lump(0.008, 0.004, -0.006);
  const auto state_at = [&](const Vec3& x) {
    constexpr double width2 = 36e-6, depth = 0.02;
    const Vec3 d = x - lump, k(250, 250, 420);
    const double e = depth * std::exp(-0.5 * d.squaredNorm() / width2);
    State state;
    state.at = x;
    state.force = -k.cwiseProduct(x) + e / width2 * d;
    state.stiffness =
        Mat3(k.asDiagonal()) - e * (Mat3::Identity() / width2 - d * d.transpose() / (width2 * width2));
    return state;
  };
  const StateSpaceOptions space{.spacing = 0.005, .box = {Vec3::Constant(-0.02), Vec3::Constant(0.02)}};
  std::vector<Vec3> candidates;
  for (int i = 0; i < 729; ++i) candidates.push_back(0.005 * Vec3(i % 9 - 4, i / 9 % 9 - 4, i / 81 - 4));
  CandidateErrors lazy(candidates, space, {});
  StateSpace known(space);
  std::vector<double> weights(candidates.size(), 1);
  const auto tell = [&](std::size_t i) {
    weights[i] = 0;
    lazy.tell(state_at(candidates[i]));
    known.insert(state_at(candidates[i]));
  };
  for (const std::size_t i : {364, 0, 8, 72, 80, 648, 656, 720, 728}) tell(i);
  double share = 0;
  constexpr int asked = 60;
  for (int k = 0; k < asked; ++k) {
    const auto found = lazy.worst(weights);
    REQUIRE(found);
    REQUIRE(weights[found->index] > 0);
    if (k % 6 == 5) {  // beside one that judges all
      ErrorEstimator all(known, {});
      double most = 0;
      for (std::size_t i = 0; i < candidates.size(); ++i)
        most = std::max(most, weights[i] * all(candidates[i]));
      share += all(candidates[found->index]) / most;
      CHECK(found->estimate == Approx(all(candidates[found->index])));
    }
    tell(found->index);
  }
  CHECK(share > 0.6 * asked / 6);  // of the largest estimate of all, on average
  CHECK(lazy.judged() < 729 * 4);
  CHECK_FALSE(lazy.worst(std::vector<double>(candidates.size(), 0)));
}

TEST_CASE("a stop ends placement within a solve that takes many steps, and its state is not kept") {
  SessionInput input = small_input();
  input.touched.space.spacing = 1e-6;  // thousands of steps to each corner
  PlacementOptions options = options_of(input, 1e-3);
  options.max_states = 9;
  std::stop_source stop;
  options.stop = stop.get_token();
  const std::jthread later([&](const std::stop_token&) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    stop.request_stop();
  });
  const Placed placed = place(input, options);
  CHECK(placed.report.stopped);
  CHECK(placed.report.solved <= 1);  // rest
  for (const State& s : placed.states) CHECK(s.solve.status != SolveStatus::cancelled);
}
