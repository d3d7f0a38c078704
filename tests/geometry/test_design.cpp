// Designs: how evenly they fill a box.

#include <set>

#include "geometry/common/halton.hpp"
#include "geometry/coverage/design.hpp"
#include "geometry/coverage/state_space.hpp"
#include "tests/support/test.hpp"

namespace {

const Box cube{Vec3::Constant(-0.05), Vec3::Constant(0.05)};
constexpr double h = 0.01;

std::vector<Vec3> places_of(Design design, std::uint64_t seed = 0) {
  return designed_places({.spacing = h, .box = cube, .design = design}, seed);
}

StateSpaceOptions listing(std::vector<Vec3> places) {
  return {.spacing = 1.25 * h,
          .box = cube,
          .design = Design::listed,
          .listed = std::make_shared<const std::vector<Vec3>>(std::move(places))};
}

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
    const std::vector<Vec3> places = places_of(design);
    CHECK(double(places.size()) > 0.8 * 1000);
    CHECK(double(places.size()) < 1.4 * 1000);
    CHECK(places.front().norm() < 1e-12);
    CHECK(std::ranges::all_of(places, [](const Vec3& at) {
      return cube.low.x() - 1e-12 <= at.minCoeff() && at.maxCoeff() <= cube.high.x() + 1e-12;
    }));
    CHECK(separation(places) > 1e-4);
    CHECK(std::ranges::is_sorted(places, {},
                                 [](const Vec3& at) { return std::round(at.squaredNorm() * 1e15); }));
    CHECK(places_of(design) == places);
  }
  CHECK(places_of(Design::lattice) == lattice(cube, h));
  CHECK(places_of(Design::halton, 1) != places_of(Design::halton, 2));
}

TEST_CASE(
    "the body-centred lattice covers with balls of sqrt(5)/4 of its side, the cubic one with sqrt(3)/2") {
  const double side = std::cbrt(2.0) * h;
  CHECK(covering_radius(places_of(Design::lattice)) == Approx(std::sqrt(0.75) * h).epsilon(0.1));
  CHECK(covering_radius(places_of(Design::body_centred)) == Approx(std::sqrt(5.0) / 4 * side).epsilon(0.1));
}

TEST_CASE("farthest places keep apart, Halton's fill each half of the box alike") {
  CHECK(separation(places_of(Design::farthest)) > 4 * separation(places_of(Design::halton)));
  for (const std::uint64_t seed : {0, 1, 7}) {
    const std::vector<Vec3> places = places_of(Design::halton, seed);
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
    for (const Vec3& at : places_of(design)) {
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

TEST_CASE("a listed design is the user's places in their order; labels know no other places") {
  // Gauss-Legendre points of order 8 in two halves: no lattice, no gap within, rest not among them.
  std::vector<Vec3> places;
  const double x[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  const auto at = [&](int i) { return 0.05 * (i < 4 ? -x[3 - i] : x[i - 4]); };
  for (int i = 0; i < 512; ++i) places.emplace_back(at(i % 8), at(i / 8 % 8), at(i / 64));
  const StateSpaceOptions options = listing(places);
  CHECK_NOTHROW(check_listed(options, "mine.csv"));
  CHECK(designed_places(options) == places);
  CHECK(designed_places(options, 7) == places);

  // In a box of points lambda_i < q_i < lambda_i+1 the spread is at most half its diagonal: the label follows by hand.
  StateSpace space(options);
  for (const Vec3& place : places) {
    State state;
    state.at = place;
    space.insert(state);
  }
  const double widest = at(4) - at(3);  // 18.3 mm, in the middle
  CHECK(0.5 * std::sqrt(3.0) * widest > 0.95 * 1.25 * h);
  CHECK(space.coverage(Vec3::Zero()).label == Label::sparse);
  CHECK(space.coverage(Vec3::Constant(0.5 * (at(6) + at(7)))).label == Label::safe);
  CHECK(space.coverage(Vec3::Constant(0.05)).label == Label::sparse);
  CHECK(space.coverage(Vec3::Constant(0.2)).label == Label::blank);
  for (const Vec3& q : halton_points({0.9 * cube.low, 0.9 * cube.high}, 200)) {
    const double delta = distance_to(places, q);
    CHECK(space.coverage(q).delta == Approx(delta));
    if (delta <= 1.5 * 1.25 * h) CHECK(space.label(q) <= Label::sparse);
  }
}

TEST_CASE("a list with a place outside the box or a place twice is refused, and so is listing `error`") {
  CHECK_THAT(error_of([] {
               check_listed(listing({{0, 0, 0}, {0, 0, 0.06}}), "mine.csv");
             }),
             Contains("mine.csv: place 2 at (0, 0, 0.06) lies outside the box, expected places [m] in "
                      "state_space.box"));
  CHECK_THAT(error_of([] {
               check_listed(listing({{0, 0, 0}, {0.01, 0, 0}, {0, 1e-12, 0}}), "mine.csv");
             }),
             Contains("mine.csv: place 3 at (0, 1e-12, 0) is place 1 at (0, 0, 0) again"));
  CHECK_THAT(error_of([] { designed_places({.spacing = h, .box = cube, .design = Design::error}); }),
             Contains("state_space.design", "of generate"));
}
