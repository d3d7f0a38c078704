#include "geometry/coverage/octree_index.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/setups.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double h = 0.006;

bool touch(const Box& a, const Box& b) {
  return (a.low.array() <= b.high.array() + 1e-12).all() && (b.low.array() <= a.high.array() + 1e-12).all();
}

}  // namespace

TEST_CASE("octree and Delaunay labels agree on 95 % of the volume of every built-in setup") {
  for (const std::string& name : setup_names()) {
    const Setup setup = make_setup(name, {.depth = 5, .half_width = 6});
    StateSpace space({.spacing = h, .box = setup.box});
    OctreeIndex octree(h);
    for (const Vec3& p : setup.states) {
      State state;
      state.at = p;
      octree.insert(space.insert(state).id, p);
    }
    const Agreement agreement = compare_indexes(space.regions(), octree);
    INFO(name << ": " << agreement.share);
    CHECK(agreement.share >= 0.95);
    double all = 0;
    for (const auto& row : agreement.volume)
      for (const double v : row) all += v;
    CHECK(all == Approx(setup.box.size().prod()));
  }
}

TEST_CASE("erased states are gone from the octree, the others are found") {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-0.05, 0.05);
  OctreeIndex octree(h);
  std::map<std::uint32_t, Vec3> kept;
  for (std::uint32_t id = 0; id < 3000; ++id) {
    const Vec3 p =
        id % 10 == 9 ? kept.begin()->second : Vec3(uniform(random), uniform(random), uniform(random));
    octree.insert({id}, p);
    kept[id] = p;
    if (id % 3 == 2) {
      auto gone = kept.begin();
      std::advance(gone, static_cast<long>(random() % kept.size()));
      REQUIRE(octree.erase({gone->first}));
      REQUIRE_FALSE(octree.erase({gone->first}));
      kept.erase(gone);
    }
  }
  CHECK(octree.size() == kept.size());
  std::vector<StateId> found;
  for (int i = 0; i < 200; ++i) {
    const Vec3 q(uniform(random), uniform(random), uniform(random));
    std::vector<std::pair<double, std::uint32_t>> sorted;
    for (const auto& [id, p] : kept) sorted.emplace_back((p - q).squaredNorm(), id);
    std::sort(sorted.begin(), sorted.end());
    octree.nearest(q, 12, found);
    REQUIRE(found.size() == 12);
    for (std::size_t k = 0; k < 12; ++k) REQUIRE(found[k].value == sorted[k].second);
    REQUIRE(octree.coverage(q).label == octree.label(q));
  }
}

TEST_CASE("the adaptive lattice is balanced, refined where wanted, and covers its box once") {
  AdaptiveLattice adaptive({Vec3(-0.03, -0.03, -0.03), Vec3(0.03, 0.03, 0.03)}, 0.012);
  const Vec3 focus(0.0051, 0.0003, -0.0078);
  adaptive.refine([&](const LatticeLeaf& leaf) { return leaf.box.contains(focus) ? 0.0008 : 0.012; });
  const std::vector<LatticeLeaf> leaves = adaptive.leaves();
  double volume = 0;
  for (const LatticeLeaf& a : leaves) {
    volume += a.box.size().prod();
    for (const LatticeLeaf& b : leaves)
      if (touch(a.box, b.box)) REQUIRE(std::abs(a.level - b.level) <= 1);
  }
  CHECK(volume == Approx(std::pow(0.072, 3)));
  CHECK(adaptive.leaf_at(focus).spacing == Approx(0.00075));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-0.03, 0.03);
  for (int i = 0; i < 300; ++i) {
    const Vec3 q(uniform(random), uniform(random), uniform(random));
    const LatticeLeaf own = adaptive.leaf_at(q);
    REQUIRE(own.box.contains(q));
    double largest = 0;
    for (const LatticeLeaf& other : leaves)
      if (touch(own.box, other.box)) largest = std::max(largest, other.spacing);
    REQUIRE(adaptive.spacing_at(q) == Approx(largest));
  }
}

TEST_CASE("the points of a lattice without refinement are {k h} around rest, outward") {
  AdaptiveLattice lattice({Vec3(-0.012, -0.012, -0.012), Vec3(0.012, 0.012, 0.012)}, h);
  CHECK(lattice.points().size() == 125);
  CHECK(lattice.points()[0].at == Vec3::Zero());
  lattice.refine([](const LatticeLeaf& leaf) { return leaf.box.low.x() >= 0 ? 0.5 * h : h; }, 1);
  OctreeIndex octree(lattice);
  for (const auto& point : lattice.points())
    octree.insert({static_cast<std::uint32_t>(octree.size())}, point.at);
  CHECK(octree.label({0.0076, 0.0011, 0.0013}) == Label::safe);
}
