// Policies of the literature: the order of places on a known motion; the greedy order against brute force; chance.

#include "scheduling/motion/random.hpp"
#include "scheduling/policy/need_policy.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/policy/utility_need.hpp"
#include "small_body.hpp"

namespace {

constexpr double h = 0.006, speed = 0.06;  // [m], [m/s]: small_body's spacing in 0.1 s

StateSpace box_without_states() {
  StateSpaceOptions options = small_input().touched.space;
  options.box = {Vec3::Constant(-0.048), Vec3::Constant(0.048)};
  return StateSpace(options);
}

std::vector<Prediction> straight(double deviation = 0) {
  std::vector<Prediction> path;
  for (int i = 0; i <= 8; ++i)
    path.push_back({.horizon = 0.1 * i, .at = Vec3(speed * 0.1 * i, 0, 0), .deviation = deviation * 0.1 * i});
  return path;
}

PlannerView view_of(const StateSpace& space, std::span<const Prediction> path, double solve) {
  return {.space = space,
          .now = 0,
          .hip = {.t = 0, .at = Vec3::Zero(), .velocity = Vec3(speed, 0, 0)},
          .predicted = path,
          .solve_seconds = solve,
          .workers = 1,
          .pending = {}};
}

}  // namespace

TEST_CASE("deadline and slack: the order of places on a straight motion") {
  const StateSpace space = box_without_states();
  const auto path = straight();
  const PlannerView view = view_of(space, path, 0.25);
  const auto worth = [&](const char* name, double x, double y) {
    return make_policy(name)->priority({.at = Vec3(x, y, 0)}, view);
  };
  // The hand enters the place of x, on its way, at (x - h) / v; that of (x, y) at (x - sqrt(h^2 - y^2)) / v.
  const auto due = [](double x, double y) {
    return std::max(0.0, (x - std::sqrt(h * h * (1 + 1e-9) * (1 + 1e-9) - y * y)) / speed);
  };
  for (const double x : {0.012, 0.018, 0.0233, 0.036})
    for (const double y : {0.0, 0.003, 0.0059}) {
      CAPTURE(x, y);
      CHECK(worth("deadline", x, y) == Approx(0.5 + 0.5 * 0.25 / (0.25 + due(x, y))).epsilon(2e-6));
    }
  CHECK(worth("deadline", 0.012, 0) > worth("deadline", 0.018, 0));
  CHECK(worth("deadline", 0.003, 0) > worth("deadline", 0.012, 0));
  // Off the path there is no deadline, however near the place is.
  for (const char* name : {"deadline", "slack"}) CHECK(worth(name, 0.042, 0) > worth(name, 0, 0.0061));
  // 0.018 is entered after 0.2 s, a solve takes 0.25 s: too late, so it follows what can be met.
  CHECK(worth("slack", 0.024, 0) > worth("slack", 0.03, 0));
  CHECK(worth("slack", 0.048, 0) > worth("slack", 0.018, 0));
  CHECK(worth("slack", 0.018, 0) > worth("slack", 0.012, 0));
  CHECK(worth("deadline", 0.018, 0) > worth("deadline", 0.024, 0));
}

TEST_CASE(
    "utility: its greedy choice is that of brute force, and a greedy set has 1 - 1/e of the best gain") {
  StateSpace space = box_without_states();
  const auto path = straight(0.02), straight_path = straight();
  PlannerView view = view_of(space, path, 0.15);
  std::vector<Candidate> candidates;
  for (int i = -1; i <= 8; ++i)
    for (int j = -1; j <= 1; ++j) candidates.push_back({.at = h * Vec3(i, j, 0.3 * j)});
  UtilityNeed need;
  need.look(view);
  const std::vector<UtilityNeed::Place> places(need.places().begin(), need.places().end());
  UtilityNeed certain;
  certain.look(view_of(space, straight_path, 0.15));
  // Only what comes after a solve, with the mean of the prediction there.
  double first = 1, weight = 0;
  Vec3 mean = Vec3::Zero();
  for (const auto& place : certain.places()) {
    first = std::min(first, place.at.x());
    weight += place.weight;
    mean += place.weight * place.at;
  }
  CHECK(weight == Approx(0.8 - 0.15));
  CHECK(places.size() == 16 * certain.places().size());
  CHECK(first > speed * 0.1);
  CHECK((mean / weight - Vec3(speed * 0.5 * (0.8 + 0.15), 0, 0)).norm() < 1e-3);
  // The gain from the definition, with the prior of the fit: m = exp(-2.5) (delta / h)^1.6.
  const auto loss = [](double delta) {
    const double m = std::exp(-2.5 + 1.6 * std::log(std::max(delta / h, 0.05)));
    return m / (1 + m);
  };
  const auto gain = [&](const std::vector<std::size_t>& set) {
    double sum = 0;
    for (const auto& place : places) {
      double delta = 5 * h;
      for (const std::size_t i : set) delta = std::min(delta, (candidates[i].at - place.at).norm());
      sum += place.weight * (loss(5 * h) - loss(delta));
    }
    return sum / weight / 0.15;
  };
  std::vector<double> out(candidates.size());
  need.worth(candidates, out);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    CAPTURE(i);
    CHECK(out[i] == Approx(gain({i})).epsilon(1e-3));
  }
  std::vector<std::size_t> chosen;
  std::vector<Vec3> pending;
  for (int k = 0; k < 2; ++k) {
    need.pend(pending);
    need.worth(candidates, out);
    chosen.push_back(static_cast<std::size_t>(std::ranges::max_element(out) - out.begin()));
    pending.push_back(candidates[chosen.back()].at);
  }
  double best = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) best = std::max(best, gain({i, j}));
  CHECK(gain(chosen) > (1 - std::exp(-1)) * best);
  CHECK(gain(chosen) > gain({chosen[0]}));
  CHECK(gain(chosen) <= best * (1 + 1e-9));
  // An uncertain hand is worth less than a certain one at the place where it is expected.
  const auto sure = straight(), wide = straight(0.1);
  const auto at_its_end = [&](const std::vector<Prediction>& ahead) {
    const auto policy = make_policy("utility");
    const PlannerView now = view_of(space, ahead, 0.15);
    policy->look(now);
    return policy->priority({.at = Vec3(0.024, 0, 0)}, now);
  };
  CHECK(at_its_end(sure) > at_its_end(wide));
}

TEST_CASE("random: a uniform order of places that repeats and differs by seed") {
  const StateSpace space = box_without_states();
  const PlannerView view = view_of(space, {}, 0.1);
  std::vector<Candidate> candidates;
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) candidates.push_back({.at = h * Vec3(i, j, -i)});
  const auto ask = [&](std::uint64_t seed) {
    std::vector<double> out(candidates.size());
    make_policy("random", {.seed = seed})->prioritise(candidates, view, out);
    return out;
  };
  const std::vector<double> one = ask(1);
  CHECK(one == ask(1));
  CHECK(one != ask(2));
  // Kolmogorov and Smirnov: the largest distance from the uniform distribution, 1 % level.
  std::vector<double> sorted = one;
  std::ranges::sort(sorted);
  double farthest = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i)
    farthest = std::max(farthest, std::abs(2 * sorted[i] - 1 - (static_cast<double>(i) + 0.5) / 400));
  CHECK(farthest < 1.63 / std::sqrt(400.0));
  // Each place is first for about one seed in eight.
  candidates.resize(8);
  std::array<int, 8> firsts{};
  for (std::uint64_t seed = 0; seed < 800; ++seed) {
    const std::vector<double> out = ask(seed);
    ++firsts[static_cast<std::size_t>(std::ranges::max_element(out) - out.begin())];
  }
  for (const int n : firsts) CHECK(std::abs(n - 100) < 40);
}

TEST_CASE("placebos are the policies without information") {
  for (const char* name : {"random", "shuffled", "error-shuffled", "clairvoyant-shuffled"})
    CHECK(is_placebo(name));
  for (const char* name : {"coverage", "utility", "clairvoyant", "nearest"}) CHECK_FALSE(is_placebo(name));
}
