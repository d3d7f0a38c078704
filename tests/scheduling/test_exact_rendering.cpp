#include "scheduling/judge/visited_cells.hpp"
#include "scheduling/record/exact_rendering.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double stiffness = 100;  // [N/m]

Vec3 spring(const Vec3& x) {
  return -stiffness * x;
}

// Along x at a constant speed, in frames of 1 ms.
std::vector<Vec3> straight(double speed, double seconds) {
  std::vector<Vec3> motion;
  for (int k = 0; k < std::lround(seconds * 1e3); ++k) motion.push_back(Vec3(speed * 1e-3 * k, 0, 0));
  return motion;
}

std::vector<std::size_t> all_of(const std::vector<Vec3>& motion) {
  std::vector<std::size_t> indices(motion.size());
  for (std::size_t k = 0; k < indices.size(); ++k) indices[k] = k;
  return indices;
}

}  // namespace

// With f = -k x, x = v t and |e|' = -a (k v t - |e|), a = 7 / s, from |e| = k v T at T on:
//   |e| = k v (t + 1 / a - exp(a (t - T)) / a)
// for any k and v. e vanishes at 1 + a t = exp(a (t - T)), and is below 7 % of |f| from 1 + 0.93 a t =
// exp(a (t - T)) on.
TEST_CASE("Exact models on a spring pulled at constant speed fade in as their equation says") {
  for (const double known : {0.06, 0.1, 0.2}) {
    CAPTURE(known);
    const auto root = [&](double share) {
      double low = 1e-3, high = 2;  // of t - T
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (std::exp(7 * middle) > 1 + share * 7 * (known + middle) ? high : low) = middle;
      }
      return low;
    };
    const auto motion = straight(0.5, 3);
    const ExactRendering r = render_exact(motion, all_of(motion), known, {}, 0.07, spring);
    CHECK(r.known == Approx(known));
    // steps of 1 ms and the first of at least 1 mN: a few frames off
    CHECK(r.settled == Approx(known + root(1)).margin(0.004));
    const double lost = static_cast<double>(r.visits - r.within) * 1e-3;
    CHECK(lost == Approx(known + root(0.93)).margin(0.004));
    CHECK(r.visits == motion.size());
  }
}

TEST_CASE("Without a switch to wait for only what comes before the first state is lost") {
  const auto motion = straight(0.5, 1);
  std::vector<Vec3> still(1000, Vec3(0.02, 0, 0));
  // Known before the first frame, where the force is zero: nothing fades in.
  const ExactRendering at_rest = render_exact(motion, all_of(motion), 0, {}, 0.07, spring);
  CHECK(at_rest.settled == 0);
  CHECK(at_rest.within == at_rest.visits);
  // Held at 2 N: 1 mN a frame up to 1 / 7 N, then 0.7 % a frame up to 1.86 N. 143 + ln(13.02) / ln(1.007) =
  // 511 frames.
  const ExactRendering held = render_exact(still, all_of(still), 0.1, {}, 0.07, spring);
  CHECK(static_cast<double>(held.visits - held.within) == Approx(100 + 511).margin(2));
  // The force never becomes known: no first visit is within the tolerance.
  const ExactRendering never = render_exact(still, all_of(still), 5, {}, 0.07, spring);
  CHECK(never.within == 0);
  CHECK(std::isinf(never.settled));
}

// F = c f while f is unknown; then |e| = |c - 1| |f| at first. Held at f: F = c f grows by 0.7 % a frame up
// to 0.93 f, or falls by as much down to 1.07 f.
TEST_CASE("A first guess leaves what it is off to fade out") {
  const std::vector<Vec3> still(1000, Vec3(0.02, 0, 0));
  for (const double c : {0.25, 0.5, 0.8, 1.0, 1.5, 4.0}) {
    CAPTURE(c);
    const ExactRendering r = render_exact(still, all_of(still), 0.1, {}, 0.07, spring,
                                          [&](const Vec3& x) { return Vec3(c * spring(x)); });
    const double frames = c < 1   ? std::log(0.93 / c) / std::log(1.007)
                          : c > 1 ? std::log(c / 1.07) / -std::log(0.993)
                                  : -100;
    CHECK(static_cast<double>(r.visits - r.within) == Approx(100 + frames).margin(2));
  }
}

TEST_CASE("Exact forces are asked for only where they count, and unknown ones are left out") {
  const auto motion = straight(0.5, 3);
  std::size_t asked = 0;
  const std::vector<std::size_t> visits{0, 1000, 2999};
  const ExactRendering r = render_exact(motion, visits, 0.1, {}, 0.07, [&](const Vec3& x) {
    ++asked;
    return x.x() > 0.6 ? Vec3::Constant(unknown) : spring(x);
  });
  CHECK(r.visits == 2);  // the last one has no reference
  CHECK(r.within == 2);  // at rest the force is zero
  CHECK(asked == 3 + static_cast<std::size_t>(std::lround((r.settled - r.known) * 1e3)) + 1);
}

TEST_CASE(
    "The first that can be solved is rest at a factorisation, or the cheapest state, and two messages") {
  const StateSpaceOptions space{.spacing = 0.01, .box = {Vec3::Constant(-0.03), Vec3::Constant(0.03)}};
  const auto constant = make_cost(ConstantCost{0.2}, {.seed = 1}, {});
  CHECK(first_possible(*constant, space, 0, true) == Approx(0.05));
  CHECK(first_possible(*constant, space, 0.01, false) == Approx(0.22));
  const auto paper = make_cost(PaperCost{}, {.seed = 3}, {});
  double least = 1;
  for (const Vec3& x : lattice(space.box, space.spacing)) least = std::min(least, paper->seconds(x));
  CHECK(first_possible(*paper, space, 0, false) == Approx(least));
  CHECK(first_possible(*paper, space, 0, true) == Approx(std::min(least, paper->rest_seconds())));
}

TEST_CASE("Cells are visited once, and those that leave the box not at all") {
  VisitedCells cells({Vec3::Constant(-0.036), Vec3::Constant(0.036)}, 0.006);
  CHECK(cells.first(Vec3(0.001, 0.001, 0.001)));
  CHECK_FALSE(cells.first(Vec3(0.005, 0.002, 0.003)));
  CHECK(cells.first(Vec3(-0.001, 0.002, 0.003)));
  CHECK(cells.first(Vec3(0.0359, 0, 0)));  // its far face is the box's own
  CHECK_FALSE(cells.first(Vec3(0.0361, 0, 0)));
  CHECK(cells.count() == 3);
}
