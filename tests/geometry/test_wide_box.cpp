// States in small clusters far from each other: cells that span the empty box between them are labelled near states
// alone. The labels must be those of the triangulation of all states at every voxel.

#include <omp.h>

#include <algorithm>
#include <random>

#include "geometry/coverage/region_summary.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double side = 0.01;  // h [m]

// Scattered clusters; some have all states in one plane or on one line, so that cells are flat.
std::vector<Vec3> far_clusters(std::uint64_t seed, double wide) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vec3> all;
  for (int cluster = 0; cluster < 6; ++cluster) {
    const Vec3 middle = 0.85 * wide * side * Vec3(uniform(random), uniform(random), uniform(random));
    for (int i = 0; i < 60; ++i) {
      Vec3 off = 1.7 * side * Vec3(uniform(random), uniform(random), uniform(random));
      if (cluster == 1) off.z() = 0;
      if (cluster == 2) off.y() = off.z() = 0;
      all.push_back(middle + off);
    }
  }
  return all;
}

RegionSummary with_threads(const StateSpace& space, int threads) {
  const int before = omp_get_max_threads();
  omp_set_num_threads(threads);
  RegionSummary found = space.regions().summary();
  omp_set_num_threads(before);
  return found;
}

bool equal(const RegionSummary& a, const RegionSummary& b) {
  return std::ranges::equal(a.leaves, b.leaves, [](const RegionLeaf& x, const RegionLeaf& y) {
    return x.label == y.label && x.box.low == y.box.low && x.box.high == y.box.high;
  });
}

}  // namespace

TEST_CASE("far clusters in a wide box: each voxel has the label of the triangulation of all states") {
  constexpr double wide = 9;  // half side of the box [h]
  const Box box{Vec3::Constant(-wide * side), Vec3(wide, wide, 0.8 * wide) * side};
  for (const std::uint64_t seed : {1u, 2u}) {
    StateSpace space({.spacing = side, .box = box});
    for (const Vec3& at : far_clusters(seed, wide)) {
      State state;
      state.at = at;
      space.insert(std::move(state));
    }
    const RegionSummary found = with_threads(space, 1);
    const RegionSummary plain =
        sample_regions(box, side, 2 * side, [&](const Vec3& q) { return space.label(q); });
    for (const Label label : all_labels) REQUIRE(plain.volume[label] > 0);
    REQUIRE(equal(found, plain));
    REQUIRE(equal(found, with_threads(space, 2)));
  }
}
