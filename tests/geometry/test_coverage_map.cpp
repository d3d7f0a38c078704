// The map of coverage, made in blocks, against the regions of one triangulation of all states.

#include <omp.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <set>

#include "geometry/coverage/coverage_map.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"
#include "tests/support/slow.hpp"

using namespace forefeel;

namespace {

constexpr double h = 0.004;
const Box box{Vec3::Constant(-0.04), Vec3::Constant(0.04)};

class Places {
 public:
  Vec3 uniform(double reach) { return {reach * unit(), reach * unit(), reach * unit()}; }
  Vec3 normal() { return {gauss_(random_), gauss_(random_), gauss_(random_)}; }
  double unit() { return uniform_(random_); }

 private:
  std::mt19937_64 random_{11};
  std::uniform_real_distribution<double> uniform_{-1, 1};
  std::normal_distribution<double> gauss_;
};

std::vector<Vec3> scattered(std::size_t n) {
  Places places;
  std::vector<Vec3> at;
  while (at.size() < n)
    if (const Vec3 p = places.uniform(0.04); p.head<2>().norm() > 0.012)
      at.push_back(p);  // a channel is empty
  return at;
}

// Every other state repeats an earlier one.
std::vector<Vec3> repeated(std::size_t n) {
  std::vector<Vec3> at = scattered(n);
  for (std::size_t i = 1; i < n; i += 2) at[i] = at[i / 2];
  return at;
}

// A slab of it is missing.
std::vector<Vec3> lattice_with_gap() {
  std::vector<Vec3> at;
  for (const Vec3& p : lattice(box, h))
    if (p.x() < -0.012 || p.x() > 0.012) at.push_back(p);
  return at;
}

std::vector<Vec3> spheres(std::size_t n) {
  Places places;
  std::vector<Vec3> at;
  for (std::size_t i = 0; i < n; ++i)
    at.push_back((0.01 + 0.01 * double(i % 3)) * places.normal().normalized());
  return at;
}

std::vector<Vec3> clusters(std::size_t n) {
  Places places;
  std::vector<Vec3> centres, at;
  for (int i = 0; i < 6; ++i) centres.push_back(places.uniform(0.04));
  for (std::size_t i = 0; i < n; ++i) at.push_back(centres[i % 6] + 0.003 * places.normal());
  return at;
}

RegionSummary by_triangulation(std::span<const Vec3> states, double& fill, std::optional<EmptyBall>& hole) {
  StateSpace space({.spacing = h, .box = box});
  for (const Vec3& at : states) {
    State state;
    state.at = at;
    space.insert(state);
  }
  fill = space.regions().fill_distance();
  hole = space.regions().largest_hole();
  return space.regions().summary();
}

// Same cubes, labels and components; those of equal volume may be numbered in another order.
void check_same(const RegionSummary& map, const RegionSummary& regions) {
  REQUIRE(map.leaves.size() == regions.leaves.size());
  CHECK(map.leaf_count == regions.leaf_count);
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  bool cubes = true;
  for (std::size_t i = 0; i < map.leaves.size(); ++i) {
    const RegionLeaf &a = map.leaves[i], &b = regions.leaves[i];
    cubes = cubes && a.label == b.label && a.box.low == b.box.low && a.box.high == b.box.high;
    pairs.insert({a.component, b.component});
  }
  CHECK(cubes);
  REQUIRE(map.components.size() == regions.components.size());
  REQUIRE(pairs.size() == map.components.size());
  std::vector<std::uint32_t> other(pairs.size());
  for (const auto& [a, b] : pairs) other[a] = b;
  for (const auto& [a, b] : pairs) {
    const RegionComponent &mine = map.components[a], &theirs = regions.components[b];
    CHECK(mine.volume == Approx(theirs.volume).epsilon(1e-9));
    CHECK((mine.bounds.low - theirs.bounds.low).norm() + (mine.bounds.high - theirs.bounds.high).norm() <
          1e-12);
    std::vector<std::uint32_t> safe;
    for (const std::uint32_t c : mine.safe_neighbours) safe.push_back(other[c]);
    std::ranges::sort(safe);
    CHECK(safe == theirs.safe_neighbours);
    CHECK(mine.sides.size() == theirs.sides.size());
  }
  for (std::size_t label = 0; label < 4; ++label) {
    CHECK(map.volume[label] == Approx(regions.volume[label]).epsilon(1e-9).margin(1e-18));
    CHECK(map.component_count[label] == regions.component_count[label]);
  }
}

bool same_bits(const RegionSummary& a, const RegionSummary& b) {
  return std::ranges::equal(a.leaves, b.leaves,
                            [](const RegionLeaf& x, const RegionLeaf& y) {
                              return x.label == y.label && x.component == y.component &&
                                     x.box.low == y.box.low && x.box.high == y.box.high;
                            }) &&
         std::ranges::equal(
             a.components, b.components, [](const RegionComponent& x, const RegionComponent& y) {
               return x.volume == y.volume && x.inner == y.inner && x.safe_neighbours == y.safe_neighbours;
             });
}

}  // namespace

TEST_CASE("a map has the regions of one triangulation of all states") {
  struct Case {
    const char* name;
    std::vector<Vec3> states;
  };
  const std::vector<Case> cases{{"scattered", scattered(3000)}, {"repeated", repeated(3000)},
                                {"lattice", lattice(box, h)},   {"lattice with a gap", lattice_with_gap()},
                                {"cospherical", spheres(1500)}, {"clusters", clusters(3000)},
                                {"few", scattered(5)},          {"two", scattered(2)},
                                {"coarse for h", scattered(60)}};
  for (const auto& [name, states] : cases) {
    INFO(name);
    double fill = 0;
    std::optional<EmptyBall> hole;
    const RegionSummary regions = by_triangulation(states, fill, hole);
    const CoverageMap map(states, {.spacing = h, .box = box});
    check_same(map.summary(true), regions);
    CHECK(map.fill_distance() == Approx(fill).epsilon(1e-9));
    REQUIRE(map.largest_hole().has_value() == hole.has_value());
    if (hole) CHECK(map.largest_hole()->radius == Approx(hole->radius).epsilon(1e-9));
    bool leaves_hold = true;
    for (const RegionLeaf& leaf : regions.leaves)
      leaves_hold = leaves_hold && map.label_at(leaf.box.centre()) == leaf.label;
    CHECK(leaves_hold);
  }
}

// 90 thousand states fill several blocks; their labels are those of the states' own triangulation.
TEST_CASE("blocks of a map meet without a seam, for any number of threads",
          SLOW("makes maps of a hundred thousand states")) {
  const double spacing = 0.0018;
  const std::vector<Vec3> states = scattered(90'000);
  const StateSpaceOptions options{.spacing = spacing, .box = box};
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const CoverageMap one(states, options);
  const RegionSummary alone = one.summary(true);
  omp_set_num_threads(3);
  const CoverageMap three(states, options);
  CHECK(same_bits(alone, three.summary(true)));
  CHECK(one.fill_distance() == three.fill_distance());
  CHECK(one.largest_hole()->centre == three.largest_hole()->centre);
  omp_set_num_threads(before);
  StateSpace space(options);
  for (const Vec3& at : states) {
    State state;
    state.at = at;
    space.insert(state);
  }
  Places places;
  std::size_t different = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 q = places.uniform(0.04);
    different += one.label_at(q) != space.region_label(q) ? 1 : 0;
  }
  CHECK(different == 0);
}

TEST_CASE("a map without states is blank, and its fill distance infinite") {
  const CoverageMap map({}, {.spacing = h, .box = box});
  CHECK(map.label_at(Vec3::Zero()) == Label::blank);
  CHECK(std::isinf(map.fill_distance()));
  CHECK_FALSE(map.largest_hole());
}
