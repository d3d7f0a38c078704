// The surface as a place to touch: nearest places, inside and outside, random places, walks over edges.
#include <Eigen/Geometry>

#include "pad_body.hpp"
#include "solver/jet/surface_grid.hpp"
#include "solver/jet/surface_map.hpp"
#include "tests/support/test.hpp"

namespace {

// 0.1 x 0.04 x 0.04 m, clamped at x = 0.
SurfaceMap block_map() {
  return SurfaceMap(*padded_block(Law::neo_hookean));
}

}  // namespace

TEST_CASE("The nearest place of the surface, and on which side of it a point is") {
  const SurfaceMap map = block_map();
  const SurfacePlace top = map.nearest(Vec3(0.033, 0.011, 0.055));
  CHECK((top.at - Vec3(0.033, 0.011, 0.04)).norm() < 1e-15);
  CHECK((map.facet(top).normal - Vec3::UnitZ()).norm() < 1e-12);
  CHECK_FALSE(map.facet(top).clamped);
  CHECK(map.facet(map.nearest(Vec3(-0.01, 0.02, 0.02))).clamped);
  CHECK_FALSE(map.facet(map.nearest(Vec3(-0.01, 0.02, 0.05))).clamped);  // at the rim of the clamp
  CHECK(map.free_area() == Approx(4 * 0.1 * 0.04 + 0.04 * 0.04).epsilon(1e-12));
  const SurfaceGrid grid(map);
  CHECK(grid.inside(Vec3(0.05, 0.02, 0.02)));
  CHECK(grid.inside(Vec3(0.001, 0.001, 0.001)));
  CHECK_FALSE(grid.inside(Vec3(0.05, 0.02, 0.0401)));
  CHECK_FALSE(grid.inside(Vec3(0.2, 0.02, 0.02)));
  const Vec3 share = map.barycentric(top);
  const auto [a, b, c] = map.corners(top.facet);
  CHECK((share[0] * a + share[1] * b + share[2] * c - top.at).norm() < 1e-15);
}

TEST_CASE("Thickness is the way through the block, also slantwise") {
  const SurfaceMap map = block_map();
  const SurfacePlace top = map.nearest(Vec3(0.033, 0.011, 0.055)), end = map.nearest(Vec3(0.15, 0.02, 0.02));
  CHECK(map.thickness(top, Vec3::UnitZ()) == Approx(0.04).epsilon(1e-12));
  CHECK(map.thickness(end, Vec3::UnitX()) == Approx(0.1).epsilon(1e-12));
  const Vec3 aslant = Vec3(0, 1, 1).normalized();  // leaves through y = 0 after 0.011
  CHECK(map.thickness(top, aslant) == Approx(0.011 * std::sqrt(2.0)).epsilon(1e-9));
  CHECK(std::isinf(map.thickness(top, -Vec3::UnitZ())));
}

TEST_CASE("Random places are uniform by area and never clamped") {
  const SurfaceMap map = block_map();
  std::mt19937_64 random(1);
  int on_end = 0, count = 4000;
  for (int i = 0; i < count; ++i) {
    const SurfacePlace place = map.random(random);
    CHECK_FALSE(map.facet(place).clamped);
    CHECK(map.barycentric(place).minCoeff() > -1e-12);
    on_end += place.at.x() > 0.1 - 1e-9;
  }
  const double share = 0.04 * 0.04 / map.free_area();
  CHECK(std::abs(on_end - share * count) < 4 * std::sqrt(share * count));
}

TEST_CASE("A walk keeps its length, turns with the surface at edges and ends at the clamp") {
  const SurfaceMap map = block_map();
  const SurfacePlace top = map.nearest(Vec3(0.07, 0.021, 0.05));
  const SurfaceMap::Walk over =
      map.walk(top, Vec3(0, 0.03, 0.5));  // its part across the facet does not count
  CHECK(over.whole);
  CHECK((over.end.at - Vec3(0.07, 0.04, 0.029)).norm() < 1e-12);  // 19 mm to the edge, then 11 mm down
  CHECK((over.step - Vec3(0, 0, -0.03)).norm() < 1e-12);
  const SurfaceMap::Walk around = map.walk(top, Vec3(0, 0.16, 0));
  CHECK((around.end.at - top.at).norm() < 1e-12);  // once around
  const Vec3 slanted(0.013, 0.017, 0);
  CHECK(map.walk(top, slanted).step.norm() == Approx(slanted.norm()).epsilon(1e-12));
  const SurfaceMap::Walk there = map.walk(top, Vec3(0.01, 0.035, 0));
  const SurfaceMap::Walk back = map.walk(there.end, -there.step);
  CHECK((back.end.at - top.at).norm() < 1e-12);
  const SurfaceMap::Walk clamped = map.walk(top, Vec3(-0.09, 0, 0));
  CHECK_FALSE(clamped.whole);
  CHECK((clamped.end.at - Vec3(0, 0.021, 0.04)).norm() < 1e-9);
}
