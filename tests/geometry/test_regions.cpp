#include "geometry/coverage/region_summary.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/setups.hpp"
#include "geometry/coverage/state_space.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double h = 0.006;

State state_at(const Vec3& at) {
  State state;
  state.at = at;
  return state;
}

bool same_leaves(const RegionSummary& a, const RegionSummary& b) {
  return std::ranges::equal(a.leaves, b.leaves, [](const RegionLeaf& x, const RegionLeaf& y) {
    return x.label == y.label && x.box.low == y.box.low && x.box.high == y.box.high;
  });
}

std::vector<Vec3> positions(int kind, const Box& box, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Vec3> all = lattice(box, h);
  if (kind == 1)  // scattered
    for (Vec3& p : all)
      p = box.low + box.size().cwiseProduct(Vec3(uniform(random), uniform(random), uniform(random)));
  if (kind == 2)  // two clusters with nothing between, and a few in the middle
    for (Vec3& p : all)
      if (std::abs(p.x()) < 0.018) p *= 0.2;
  std::shuffle(all.begin(), all.end(), random);
  all.resize(std::min<std::size_t>(all.size(), 260));
  return all;
}

}  // namespace

TEST_CASE("regions that grew with the states equal regions made at once, voxel by voxel") {
  const Box box{Vec3(-0.031, -0.013, -0.011), Vec3(0.031, 0.013, 0.014)};
  for (const std::uint64_t seed : {1u, 2u})
    for (int kind = 0; kind < 3; ++kind) {
      std::mt19937_64 random(seed);
      StateSpace grown({.spacing = h, .box = box});
      std::size_t n = 0;
      for (const Vec3& p : positions(kind, box, random)) {
        grown.insert(state_at(p));
        if (n % 97 == 0) REQUIRE(grown.regions().label_at(p) == grown.region_label(p));
        ++n;
      }
      StateSpace fresh({.spacing = h, .box = box});
      for (std::uint32_t id = 0; id < grown.size(); ++id) fresh.insert(grown[{id}]);
      const RegionSummary a = grown.regions().summary(), b = fresh.regions().summary();
      REQUIRE(same_leaves(a, b));
      // The same leaves by labelling every voxel.
      const RegionSummary sampled =
          sample_regions(box, h, 2 * h, [&](const Vec3& q) { return fresh.label(q); });
      REQUIRE(same_leaves(a, sampled));
      for (std::size_t i = 0; i < 4; ++i) {
        REQUIRE(a.volume[i] == Approx(sampled.volume[i]).margin(1e-15));
        REQUIRE(a.component_count[i] == sampled.component_count[i]);
      }
      double all = 0;
      for (const RegionLeaf& leaf : a.leaves) all += leaf.box.size().prod();
      REQUIRE(all == Approx(box.size().prod()));
    }
}

TEST_CASE("a gap names the safe components on both sides; holes have their size") {
  const Setup setup = make_setup("gap", {.depth = 3, .half_width = 4});
  StateSpace space({.spacing = h, .box = setup.box});
  for (const Vec3& p : setup.states) space.insert(state_at(p));
  const Regions made = space.regions();
  const RegionSummary regions = made.summary();
  CHECK(regions.component_count[0] == 2);
  bool bridge = false;
  for (const RegionComponent& c : regions.components)
    if (c.label == Label::gap && c.safe_neighbours.size() == 2) bridge = true;
  CHECK(bridge);
  for (const RegionLeaf& leaf : regions.leaves) REQUIRE(made.label_at(leaf.box.centre()) == leaf.label);
  // Midway between the slabs, over the middle of a lattice square: sqrt(24^2 + 3^2 + 3^2) mm.
  const auto hole = made.largest_hole();
  REQUIRE(hole);
  CHECK(hole->radius == Approx(1e-3 * std::sqrt(24.0 * 24 + 18)).epsilon(1e-9));
  CHECK(hole->centre.x() == Approx(0.024));
  CHECK(made.fill_distance() == Approx(hole->radius).epsilon(1e-3));
}

TEST_CASE("a full box is one safe component with fill distance sqrt(3)/2 h") {
  const Setup setup = make_setup("full", {.depth = 2, .half_width = 2, .width = 0.012});
  StateSpace space({.spacing = h, .box = setup.box});
  for (const Vec3& p : setup.states) space.insert(state_at(p));
  const RegionSummary regions = space.regions().summary();
  CHECK(regions.components.size() == 1);
  CHECK(regions.volume[0] == Approx(setup.box.size().prod()));
  CHECK(space.regions().fill_distance() == Approx(std::sqrt(3.0) / 2 * h).epsilon(1e-6));
  CHECK(space.regions().largest_hole()->radius == Approx(std::sqrt(3.0) / 2 * h));
}

TEST_CASE("regions of few or flat states") {
  const Box box{Vec3(-0.02, -0.02, -0.02), Vec3(0.02, 0.02, 0.02)};
  StateSpace space({.spacing = h, .box = box});
  CHECK(space.regions().summary().volume[3] == Approx(box.size().prod()));
  CHECK(std::isinf(space.regions().fill_distance()));
  CHECK_FALSE(space.regions().largest_hole());
  space.insert(state_at({0, 0, 0}));
  CHECK(space.regions().label_at({0.001, 0, 0}) == Label::sparse);
  CHECK(space.regions().fill_distance() == Approx(0.02 * std::sqrt(3.0)).epsilon(1e-3));
  // 27 voxels of h/4 a side, centred on the box: those with their centre within 1.5 h.
  int voxels = 0;
  for (int k = -13; k <= 13; ++k)
    for (int j = -13; j <= 13; ++j)
      for (int i = -13; i <= 13; ++i) voxels += i * i + j * j + k * k <= 36;
  CHECK(space.regions().summary().volume[1] == Approx(voxels * std::pow(h / 4, 3)));
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j) space.insert(state_at(h * Vec3(i, j, 0)));
  CHECK(space.regions().summary().volume[0] == 0);
  StateSpace flat({.spacing = h, .box = {Vec3(-0.018, -0.018, 0), Vec3(0.018, 0.018, 0)}});
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j) flat.insert(state_at(h * Vec3(i, j, 0)));
  CHECK(flat.regions().label_at({0.001, 0.001, 0}) == Label::sparse);
}
