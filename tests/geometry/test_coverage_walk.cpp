// Queries along paths, the spread without a triangulation, labels on an adaptive lattice, the sides of
// bridges.

#include <Eigen/Geometry>

#include "geometry/coverage/coverage_query.hpp"
#include "geometry/coverage/octree_index.hpp"
#include "geometry/coverage/region_summary.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/setups.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/index/adaptive_lattice.hpp"
#include "geometry/index/local_spread.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double h = 0.006;

State state_at(const Vec3& at) {
  State state;
  state.at = at;
  return state;
}

// Jittered (kind 0), exact (1) or scattered (2).
std::vector<Vec3> field(int kind, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vec3> all;
  for (int k = -3; k <= 3; ++k)
    for (int j = -3; j <= 3; ++j)
      for (int i = -3; i <= 3; ++i) {
        const Vec3 noise(uniform(random), uniform(random), uniform(random));
        all.push_back(kind == 2 ? Vec3(3.4 * h * noise)
                                : Vec3(h * Vec3(i, j, k) + (kind == 0 ? 0.2 : 0.0) * h * noise));
      }
  return all;
}

}  // namespace

TEST_CASE("labels along a path equal labels asked one by one, while states arrive and for both indexes") {
  for (int kind = 0; kind < 3; ++kind)
    for (const std::uint64_t seed : {51u, 52u}) {
      std::mt19937_64 random(seed);
      std::vector<Vec3> states = field(kind, random);
      std::shuffle(states.begin(), states.end(), random);
      StateSpace space({.spacing = h});
      OctreeIndex octree(h);
      PathWalk walk, counted;
      std::vector<StateId> known;
      double s = 0;
      for (const Vec3& p : states) {
        const StateId id = space.insert(state_at(p)).id;
        octree.insert(id, p);
        known.push_back(id);
        if (known.size() % 11 == 0) {  // erases one state from the octree
          REQUIRE(octree.erase(known.front()));
          octree.insert(known.front(), space[known.front()].at);
        }
        for (int i = 0; i < 12; ++i, s += 0.004) {
          const Vec3 q =
              i % 5 == 4
                  ? Vec3(h * Vec3(std::round(2 * std::sin(s)), std::round(2 * std::cos(s)), 0))
                  : Vec3(3.6 * h * Vec3(std::sin(s), std::sin(1.3 * s + 0.4), std::sin(0.7 * s + 1.1)));
          REQUIRE(space.label(q, walk) == space.coverage(q).label);
          REQUIRE(octree.label(q, counted) == octree.coverage(q).label);
        }
      }
      // A walk of another index is only a bad place to start.
      REQUIRE(octree.label(Vec3::Zero(), walk) == octree.label(Vec3::Zero()));
      REQUIRE(space.label(Vec3::Zero(), counted) == space.label(Vec3::Zero()));
    }
}

TEST_CASE("a walk does not remember erased states") {
  OctreeIndex octree(h);
  std::uint32_t id = 0;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) octree.insert({id++}, h * Vec3(i, j, k));
  PathWalk walk;
  const Vec3 q = h * Vec3(0.52, 0.47, 0.46);
  REQUIRE(octree.label(q, walk) == Label::safe);
  REQUIRE(octree.label(q, walk) == Label::safe);
  for (std::uint32_t gone = 1; gone < 8; ++gone) REQUIRE(octree.erase({gone}));
  CHECK(octree.label(q, walk) == Label::sparse);
}

TEST_CASE("the spread over the states around equals that of the Delaunay cell where its corners are near") {
  std::size_t equal = 0;
  for (const std::uint64_t seed : {61u, 62u, 63u}) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int kind = 0; kind < 3; ++kind) {
      PointOctree points;
      DelaunayIndex delaunay;
      std::uint32_t id = 0;
      for (const Vec3& p : field(kind, random)) {
        if (delaunay.insert({id}, p) != StateId{id}) continue;
        points.insert(id++, p);
      }
      for (int i = 0; i < 1200; ++i) {
        const Vec3 q = 3.2 * h * Vec3(uniform(random), uniform(random), uniform(random));
        std::vector<Vec3> offsets;
        points.for_each_within(q, 1.45 * h,
                               [&](std::uint32_t, const Vec3& d, double) { offsets.push_back(d); });
        std::shuffle(offsets.begin(), offsets.end(), random);
        const LocalSpread local = least_spread(offsets, h);
        const Spread whole = delaunay.spread(q, {});
        const bool near = whole.inside && std::ranges::all_of(whole.at, [&](const Vec3& p) {
                            return (p - q).norm() <= 1.45 * h;
                          });
        if (near) {
          REQUIRE(local.spread == Approx(whole.spread).epsilon(1e-8));
          ++equal;
        } else if (std::isfinite(local.spread)) {
          REQUIRE(whole.spread <= local.spread * (1 + 1e-9));
        }
      }
    }
  }
  CHECK(equal > 4000);
}

TEST_CASE("what the octree calls safe the triangulation calls safe") {
  for (const std::string& name : setup_names())
    for (const double width : {0.048, 0.120}) {
      const Setup setup = make_setup(name, {.depth = 4, .half_width = 5, .width = width});
      StateSpace space({.spacing = h});
      OctreeIndex octree(h);
      for (const Vec3& p : setup.states) octree.insert(space.insert(state_at(p)).id, p);
      std::mt19937_64 random(7);
      std::uniform_real_distribution<double> uniform(0, 1);
      for (int i = 0; i < 1500; ++i) {
        const Vec3 q = setup.box.low +
                       setup.box.size().cwiseProduct(Vec3(uniform(random), uniform(random), uniform(random)));
        if (octree.label(q) == Label::safe) REQUIRE(space.label(q) == Label::safe);
      }
    }
}

TEST_CASE("on an adaptive lattice labels and regions use h(q), and regions follow insertions") {
  const Box box{Vec3(-4 * h, -4 * h, -4 * h), Vec3(4 * h, 4 * h, 4 * h)};
  AdaptiveLattice made(box, 2 * h);
  made.refine([](const LatticeLeaf& leaf) { return leaf.box.low.minCoeff() >= 0 ? h : 2 * h; }, 1);
  const auto lattice = std::make_shared<const AdaptiveLattice>(made);
  StateSpace space({.spacing = h, .box = box, .lattice = lattice});
  std::vector<AdaptiveLattice::Point> points = lattice->points();
  std::mt19937_64 random(9);
  std::shuffle(points.begin(), points.end(), random);
  for (std::size_t i = 0; i < points.size(); ++i) {
    space.insert(state_at(points[i].at));
    if (i % 60 == 0) REQUIRE(space.regions().label_at(points[i].at) == space.region_label(points[i].at));
    if (i % 90 != 0 && i + 1 != points.size()) continue;
    const RegionSummary grown = space.regions().summary();
    const RegionSummary sampled =
        sample_regions(box, h, 2 * h, [&](const Vec3& q) { return space.label(q); });
    for (std::size_t label = 0; label < 4; ++label)
      REQUIRE(grown.volume[label] == Approx(sampled.volume[label]).margin(1e-15));
  }
  CHECK(space.spacing_at({-h, -h, -h}) == Approx(2 * h));
  CHECK(space.spacing_at({3.5 * h, 3.5 * h, 3.5 * h}) == Approx(h));
  CHECK(space.regions().summary().volume[0] == Approx(box.size().prod()));  // everywhere as dense as wanted
  const Vec3 coarse(-2.9 * h, -3.1 * h, -2.8 * h);
  CHECK(space.label(coarse) == Label::safe);
  StateSpace strict({.spacing = h, .box = box});
  for (const auto& p : points) strict.insert(state_at(p.at));
  CHECK(strict.label(coarse) != Label::safe);
}

TEST_CASE("the lattice of states that name their spacings is the one they came from") {
  const Box box{Vec3(-4 * h, -4 * h, -4 * h), Vec3(4 * h, 4 * h, 4 * h)};
  AdaptiveLattice made(box, 2 * h);
  made.refine([](const LatticeLeaf& leaf) { return leaf.box.low.minCoeff() >= 0 ? 0.5 * h : 2 * h; });
  std::vector<State> states;
  for (const AdaptiveLattice::Point& p : made.points()) {
    states.push_back(state_at(p.at));
    states.back().spacing = p.spacing;
  }
  const auto found = lattice_of(states, box);
  REQUIRE(found);
  const auto a = made.leaves(), b = found->leaves();
  REQUIRE(a.size() == b.size());
  for (const LatticeLeaf& leaf : a)
    REQUIRE(found->leaf_at(leaf.box.centre()).spacing == Approx(leaf.spacing));
  for (State& s : states) s.spacing = h;
  CHECK_FALSE(lattice_of(states, box));
}

TEST_CASE("bridges have as many sides as areas they meet") {
  std::vector<Vec3> offsets;
  const auto slab = [&](const Vec3& normal, double distance) {
    const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
    for (int i = -8; i <= 8; ++i)
      for (int j = -8; j <= 8; ++j)
        if (const Vec3 p = distance * normal + h * (i * u + j * v); p.norm() <= 8 * h) offsets.push_back(p);
  };
  const double link = bridge_link_deg(1.5);
  CHECK(link == Approx(38.942).epsilon(1e-4));
  CHECK(bridge_sides(offsets, link).empty());
  slab(Vec3::UnitX(), 3 * h);
  CHECK(bridge_sides(offsets, link).size() == 1);
  slab(-Vec3::UnitX(), 5 * h);
  const auto two = bridge_sides(offsets, link);
  REQUIRE(two.size() == 2);
  CHECK(two[0].direction.x() == Approx(1).epsilon(1e-3));
  CHECK(two[1].direction.x() == Approx(-1).epsilon(1e-3));
  CHECK(two[0].distance == Approx(3 * h));
  CHECK(two[0].half_angle_deg == Approx(68).margin(4));  // acos(3 / 8)
  CHECK(two[0].states + two[1].states == offsets.size());
  // States all round a hole of 3 x 3 x 3 are one side without a border.
  offsets.clear();
  for (int k = -3; k <= 3; ++k)
    for (int j = -3; j <= 3; ++j)
      for (int i = -3; i <= 3; ++i)
        if (std::max({std::abs(i), std::abs(j), std::abs(k)}) > 1) offsets.push_back(h * Vec3(i, j, k));
  CHECK(bridge_sides(offsets, link).size() == 1);
}

TEST_CASE("the largest distance in a box is found within the tolerance") {
  std::mt19937_64 random(71);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vec3> states;
  for (int i = 0; i < 12; ++i) states.emplace_back(uniform(random), uniform(random), uniform(random));
  const auto delta = [&](const Vec3& q) {
    double least = 10;
    for (const Vec3& p : states) least = std::min(least, (p - q).norm());
    return least;
  };
  const Box box{Vec3(-1, -1, -1), Vec3(1, 1, 1)};
  double sampled = 0;
  for (int k = 0; k <= 40; ++k)
    for (int j = 0; j <= 40; ++j)
      for (int i = 0; i <= 40; ++i)
        sampled = std::max(sampled, delta(Vec3(-1, -1, -1) + 0.05 * Vec3(i, j, k)));
  const double fill = largest_distance(delta, box, 0, 1e-4);
  CHECK(fill >= sampled - 1e-4);
  CHECK(fill <= sampled + 0.05 * std::sqrt(3.0) / 2);
}
