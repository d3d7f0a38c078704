#include "geometry/coverage/state_space.hpp"
#include "solver/lattice/sweep_plan.hpp"
#include "tests/support/test.hpp"

TEST_CASE(
    "coarse planes hold even multiples and the ends of the box; others lie halfway between two of them") {
  const double h = 0.006;
  for (const Box& box : {Box{Vec3(-0.018, -0.013, -0.012), Vec3(0.024, 0.013, 0.018)},
                         Box{Vec3(0.006, 0.018, -0.03), Vec3(0.03, 0.018, -0.006)}}) {
    const CoarsePlanes planes = coarse_planes(box, h);
    LatticeIndex low{99, 99, 99}, high{-99, -99, -99};
    for (const Vec3& x : lattice(box, h)) {
      const LatticeIndex k = fine_index(x, h);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], k[axis]);
        high[axis] = std::max(high[axis], k[axis]);
        const auto around = planes.around(axis, k[axis]);
        REQUIRE(around);
        CHECK(around->first + around->second == 2 * k[axis]);
        if (k[axis] % 2 == 0) CHECK(around->first == around->second);
      }
    }
    CHECK(planes.holds(low));
    CHECK(planes.holds(high));
    CHECK_FALSE(planes.around(0, low[0] - 0.5));
    CHECK_FALSE(planes.around(0, high[0] + 0.5));
  }
}

TEST_CASE("each coarse node leads to rest by steps along the axes; the corners on the way are coarse nodes") {
  const Box box{Vec3(-0.018, -0.03, -0.012), Vec3(0.024, 0.012, 0.018)};
  const CoarsePlanes planes = coarse_planes(box, LatticeOptions{}.spacing);
  LatticeOptions options;
  options.box = box;
  const SweepPlan plan(options, {});
  REQUIRE(plan.coarse().size() == planes.at[0].size() * planes.at[1].size() * planes.at[2].size());
  for (const LatticeIndex& c : plan.coarse()) {
    const std::vector<LatticeIndex> inner = inner_corners(planes, c);
    std::size_t count = 1;
    for (const int k : c) count *= k == 0 ? 1 : 2;
    CHECK(inner.size() == count);
    for (const LatticeIndex& i : inner) CHECK(planes.holds(i));
    const std::vector<LatticeIndex> parents = towards_rest(planes, c);
    CHECK(parents.empty() == (level(c) == 0));
    for (const LatticeIndex& p : parents) {
      CHECK(level(p) < level(c));
      CHECK(std::ranges::find(inner, p) != inner.end());
    }
  }
}
