// Designs: how evenly they fill a box.

#include <set>

#include "geometry/common/halton.hpp"
#include "geometry/coverage/design.hpp"
#include "geometry/coverage/state_space.hpp"
#include "tests/support/test.hpp"

namespace {

const Box cube{Vec3::Constant(-0.05), Vec3::Constant(0.05)};
constexpr double h = 0.01;

double distance_to(const std::vector<Vec3>& places, const Vec3& q) {
  double least = INFINITY;
  for (const Vec3& at : places)
    if (at != q) least = std::min(least, (at - q).norm());
  return least;
}

// The largest distance of a place of the inner part of the box to the design.
double covering_radius(const std::vector<Vec3>& places) {
  double largest = 0;
  for (const Vec3& q : halton_points({0.6 * cube.low, 0.6 * cube.high}, 3000))
    largest = std::max(largest, distance_to(places, q));
  return largest;
}

double separation(const std::vector<Vec3>& places) {
  double least = INFINITY;
  for (const Vec3& at : places) least = std::min(least, distance_to(places, at));
  return least;
}

}  // namespace

TEST_CASE("designs hold a place for each cube of the spacing, in the box, rest first") {
  for (const Design design : {Design::lattice, Design::body_centred, Design::halton, Design::farthest}) {
    CAPTURE(name(design));
    const std::vector<Vec3> places = designed_places(cube, h, design);
    CHECK(double(places.size()) > 0.8 * 1000);
    CHECK(double(places.size()) < 1.4 * 1000);
    CHECK(places.front().norm() < 1e-12);
    CHECK(std::ranges::all_of(places, [](const Vec3& at) {
      return cube.low.x() - 1e-12 <= at.minCoeff() && at.maxCoeff() <= cube.high.x() + 1e-12;
    }));
    CHECK(separation(places) > 1e-4);
    CHECK(std::ranges::is_sorted(places, {},
                                 [](const Vec3& at) { return std::round(at.squaredNorm() * 1e15); }));
    CHECK(designed_places(cube, h, design) == places);
  }
  CHECK(designed_places(cube, h, Design::lattice) == lattice(cube, h));
  CHECK(designed_places(cube, h, Design::halton, 1) != designed_places(cube, h, Design::halton, 2));
}

TEST_CASE(
    "the body-centred lattice covers with balls of sqrt(5)/4 of its side, the cubic one with sqrt(3)/2") {
  const double side = std::cbrt(2.0) * h;
  CHECK(covering_radius(designed_places(cube, h, Design::lattice)) ==
        Approx(std::sqrt(0.75) * h).epsilon(0.1));
  CHECK(covering_radius(designed_places(cube, h, Design::body_centred)) ==
        Approx(std::sqrt(5.0) / 4 * side).epsilon(0.1));
}

TEST_CASE("farthest places keep apart, Halton's fill each half of the box alike") {
  CHECK(separation(designed_places(cube, h, Design::farthest)) >
        4 * separation(designed_places(cube, h, Design::halton)));
  for (const std::uint64_t seed : {0, 1, 7}) {
    const std::vector<Vec3> places = designed_places(cube, h, Design::halton, seed);
    for (int axis = 0; axis < 3; ++axis) {
      const auto low = std::ranges::count_if(places, [&](const Vec3& at) { return at[axis] < 0; });
      CHECK(std::abs(double(low) - 0.5 * double(places.size())) < 6);  // at random 16 on the mean
    }
  }
}

TEST_CASE("labels and regions of scattered designs: nearly all of the inside is safe at their spacing") {
  for (const Design design : {Design::body_centred, Design::halton, Design::farthest}) {
    CAPTURE(name(design));
    StateSpace space({.spacing = 1.25 * h, .box = cube});
    for (const Vec3& at : designed_places(cube, h, design)) {
      State state;
      state.at = at;
      space.insert(state);
    }
    int safe = 0;
    const std::vector<Vec3> asked = halton_points({0.6 * cube.low, 0.6 * cube.high}, 500);
    for (const Vec3& q : asked) safe += space.coverage(q).label == Label::safe;
    CHECK(safe > 430);
  }
}
