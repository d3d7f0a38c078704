#include "geometry/common/union_find.hpp"
#include "geometry/coverage/region_file.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"
#include "tests/support/test.hpp"

namespace {

// Of each label: the number of parts that are connected over points.
std::array<std::size_t, 4> parts(const RegionCells& cells, const std::vector<RegionLeaf>& leaves) {
  UnionFind sets(cells.points.size());
  for (const auto& corners : cells.corners)
    for (const std::uint32_t point : corners) sets.join(corners[0], point);
  std::array<std::set<std::uint32_t>, 4> found;
  for (std::size_t i = 0; i < cells.corners.size(); ++i)
    found[static_cast<std::size_t>(leaves[cells.leaf[i]].label)].insert(sets.find(cells.corners[i][0]));
  std::array<std::size_t, 4> count{};
  for (std::size_t k = 0; k < 4; ++k) count[k] = found[k].size();
  return count;
}

double volume(const RegionCells& cells) {
  double sum = 0;
  for (const auto& c : cells.corners) sum += (cells.points[c[7]] - cells.points[c[0]]).prod();
  return sum;
}

bool every_box_lies_in_its_leaf(const RegionCells& cells, const std::vector<RegionLeaf>& leaves) {
  for (std::size_t i = 0; i < cells.corners.size(); ++i)
    for (unsigned k = 0; k < 8; ++k) {
      const Vec3& p = cells.points[cells.corners[i][k]];
      const Box& box = leaves[cells.leaf[i]].box;
      for (int axis = 0; axis < 3; ++axis) {
        const double own = cells.points[cells.corners[i][(k >> axis) & 1 ? 7 : 0]][axis];
        if (p[axis] != own || p[axis] < box.low[axis] - 1e-12 || p[axis] > box.high[axis] + 1e-12)
          return false;
      }
    }
  return true;
}

RegionLeaf leaf(const Vec3& low, double side, std::uint32_t component, Label label = Label::safe) {
  return {.box = {low, low + Vec3::Constant(side)}, .label = label, .component = component};
}

}  // namespace

TEST_CASE("parts connected over shared corners are the components, for states of every kind") {
  const Box box{Vec3(-0.031, -0.013, -0.011), Vec3(0.031, 0.0131, 0.014)};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    StateSpace space({.spacing = seed % 2 == 0 ? 0.006 : 0.0035, .box = box});
    for (int i = 0; i < 20 * static_cast<int>(seed); ++i) {
      State state;
      state.at = box.low + box.size().cwiseProduct(Vec3(uniform(random), uniform(random), uniform(random)));
      space.insert(state);
    }
    const RegionSummary regions = space.regions().summary();
    const RegionCells cells = cells_with_shared_corners(regions.leaves);
    INFO("seed " << seed);
    CHECK(parts(cells, regions.leaves) == regions.component_count.values);
    CHECK(volume(cells) == Approx(box.size().prod()));
    CHECK(every_box_lies_in_its_leaf(cells, regions.leaves));
    CHECK(cells.points.size() < 4 * cells.corners.size());
  }
}

TEST_CASE("a small leaf in the middle of a large one's facet is connected with it by cuts") {
  std::vector<RegionLeaf> leaves{leaf(Vec3::Zero(), 8, 0), leaf({3, 3, 8}, 1, 0), leaf({3, 3, 9}, 1, 0)};
  // A part of another label elsewhere, whose planes pass through the large leaf.
  for (const double at : {1.0, 2.0, 4.0, 6.0}) leaves.push_back(leaf({at, at, 20 + at}, 1, 1, Label::gap));
  const RegionCells alone = cells_with_shared_corners({leaves.data(), 3});
  CHECK(parts(alone, leaves) == std::array<std::size_t, 4>{1, 0, 0, 0});
  CHECK(volume(alone) == Approx(514));
  CHECK(every_box_lies_in_its_leaf(alone, leaves));
  const RegionCells all = cells_with_shared_corners(leaves);
  CHECK(volume(all) == Approx(518));
  CHECK(parts(all, leaves)[0] == 1);
}

TEST_CASE("components that touch over an edge share no point") {
  const std::vector<RegionLeaf> leaves{leaf(Vec3::Zero(), 1, 0), leaf({1, 1, 0}, 1, 1)};
  const RegionCells cells = cells_with_shared_corners(leaves);
  CHECK(cells.points.size() == 16);
  CHECK(parts(cells, leaves)[0] == 2);
  CHECK(cells_with_shared_corners({}).points.empty());
}
