// Regions that several threads make.

#include <omp.h>

#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double h = 0.004;

StateSpace scattered(std::size_t n) {
  const Box box{Vec3::Constant(-0.05), Vec3::Constant(0.05)};  // 4 x 4 x 4 root cubes
  StateSpace space({.spacing = h, .box = box});
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-0.05, 0.05);
  for (std::size_t i = 0; i < n; ++i) {
    State state;
    state.at = Vec3(uniform(random), uniform(random), uniform(random));
    if (state.at.head<2>().norm() > 0.012) space.insert(state);  // a channel is left empty
  }
  return space;
}

RegionSummary made_by(int threads, const StateSpace& space) {
  const int before = omp_get_max_threads();
  omp_set_num_threads(threads);
  const RegionSummary summary = space.regions().summary();
  omp_set_num_threads(before);
  return summary;
}

bool same_leaves(const RegionSummary& a, const RegionSummary& b) {
  return std::ranges::equal(a.leaves, b.leaves, [](const RegionLeaf& x, const RegionLeaf& y) {
    return x.label == y.label && x.box.low == y.box.low && x.box.high == y.box.high;
  });
}

bool same(const RegionSummary& a, const RegionSummary& b) {
  const auto same_component_of = [](const RegionLeaf& x, const RegionLeaf& y) {
    return x.component == y.component;
  };
  const auto same_component = [](const RegionComponent& x, const RegionComponent& y) {
    return x.label == y.label && x.volume == y.volume && x.leaves == y.leaves && x.inner == y.inner &&
           x.safe_neighbours == y.safe_neighbours && x.sides.size() == y.sides.size();
  };
  return same_leaves(a, b) && std::ranges::equal(a.leaves, b.leaves, same_component_of) &&
         std::ranges::equal(a.components, b.components, same_component) && a.volume == b.volume;
}

}  // namespace

TEST_CASE("regions are the same to the last bit for any number of threads") {
  const StateSpace one = scattered(9000), three = scattered(9000), seven = scattered(9000);
  const RegionSummary alone = made_by(1, one);
  CHECK(alone.component_count[0] > 0);
  CHECK(alone.component_count[2] > 0);
  CHECK(alone.leaves.size() > 10'000);
  CHECK(same(alone, made_by(3, three)));
  CHECK(same(alone, made_by(7, seven)));
}

TEST_CASE("regions of states that came in two parts equal those of all at once",
          SLOW("makes regions of thousands of states for several numbers of threads")) {
  StateSpace grown = scattered(6000), fresh = scattered(6000);
  made_by(3, grown);
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> uniform(-0.05, 0.05);
  for (int i = 0; i < 300; ++i) {
    State state;
    state.at = Vec3(uniform(random), uniform(random), uniform(random));
    grown.insert(state);
    fresh.insert(state);
  }
  CHECK(same_leaves(made_by(3, grown), made_by(1, fresh)));
}
