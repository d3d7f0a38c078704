// Regions, whose labels are made in blocks, against the labels of one triangulation of all states, voxel by voxel.

#include <omp.h>

#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/coverage/voxels.hpp"
#include "geometry/index/adaptive_lattice.hpp"
#include "geometry/index/delaunay_index.hpp"
#include "geometry/index/point_octree.hpp"
#include "tests/support/test.hpp"

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

StateSpace space_of(std::span<const Vec3> states, const StateSpaceOptions& options) {
  StateSpace space(options);
  for (const Vec3& at : states) {
    State state;
    state.at = at;
    space.insert(state);
  }
  return space;
}

struct ByTriangulation {
  RegionSummary regions;
  double fill = std::numeric_limits<double>::infinity();
  std::optional<EmptyBall> hole;

  ByTriangulation(std::span<const Vec3> states, const StateSpaceOptions& options) {
    const StateSpace space = space_of(states, options);
    const CoverageOptions& coverage = options.coverage;
    regions = sample_regions(box, options.spacing, rim_reach(coverage.sparse_distance, options.spacing),
                             [&](const Vec3& q) { return space.label(q); });
    find_sides(regions.components, coverage.sparse_distance,
               [&](const Vec3& place, std::vector<Vec3>& offsets) {
                 space.points().offsets_within(
                     place, coverage.gap_cone_radius * options.spacing * (1 + threshold_slack), offsets);
               });
    for (const DelaunayIndex::Cell& cell : space.delaunay().cells()) {
      if (!std::isfinite(cell.circumradius) || !box.contains(cell.centre)) continue;
      fill = std::max(std::isfinite(fill) ? fill : 0, cell.circumradius);
      if ((!hole || cell.circumradius > hole->radius) && space.delaunay().spread(cell.centre, {}).inside)
        hole = EmptyBall{cell.circumradius, cell.centre};
    }
    if (!states.empty()) on_faces(space, 1e-3 * options.spacing);
  }

 private:
  // The largest distance to a state at the corners and on the faces of the box.
  void on_faces(const StateSpace& space, double tolerance) {
    const auto delta = [&](const Vec3& q) { return std::sqrt(space.points().nearest(q).squared); };
    if (!std::isfinite(fill)) fill = 0;
    for (int corner = 0; corner < 8; ++corner)
      fill = std::max(fill,
                      delta({corner & 1 ? box.high.x() : box.low.x(), corner & 2 ? box.high.y() : box.low.y(),
                             corner & 4 ? box.high.z() : box.low.z()}));
    for (int axis = 0; axis < 3; ++axis)
      for (const bool upper : {false, true}) {
        Box face = box;
        (upper ? face.low : face.high)[axis] = (upper ? face.high : face.low)[axis];
        fill = largest_distance(delta, face, fill, tolerance);
      }
  }
};

// Same cubes, labels and components; those of equal volume may be numbered in another order.
void check_same(const RegionSummary& found, const RegionSummary& wanted) {
  REQUIRE(found.leaves.size() == wanted.leaves.size());
  CHECK(found.leaf_count == wanted.leaf_count);
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  bool cubes = true;
  for (std::size_t i = 0; i < found.leaves.size(); ++i) {
    const RegionLeaf &a = found.leaves[i], &b = wanted.leaves[i];
    cubes = cubes && a.label == b.label && a.box.low == b.box.low && a.box.high == b.box.high;
    pairs.insert({a.component, b.component});
  }
  CHECK(cubes);
  REQUIRE(found.components.size() == wanted.components.size());
  REQUIRE(pairs.size() == found.components.size());
  std::vector<std::uint32_t> other(pairs.size());
  for (const auto& [a, b] : pairs) other[a] = b;
  for (const auto& [a, b] : pairs) {
    const RegionComponent &mine = found.components[a], &theirs = wanted.components[b];
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
    CHECK(found.volume[label] == Approx(wanted.volume[label]).epsilon(1e-9).margin(1e-18));
    CHECK(found.component_count[label] == wanted.component_count[label]);
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

TEST_CASE("regions are those of one triangulation of all states") {
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
    const ByTriangulation wanted(states, {.spacing = h, .box = box});
    const Regions regions(states, {.spacing = h, .box = box});
    check_same(regions.summary(), wanted.regions);
    CHECK(regions.fill_distance() == Approx(wanted.fill).epsilon(1e-9));
    REQUIRE(regions.largest_hole().has_value() == wanted.hole.has_value());
    if (wanted.hole) CHECK(regions.largest_hole()->radius == Approx(wanted.hole->radius).epsilon(1e-9));
    bool leaves_hold = true;
    for (const RegionLeaf& leaf : wanted.regions.leaves)
      leaves_hold = leaves_hold && regions.label_at(leaf.box.centre()) == leaf.label;
    CHECK(leaves_hold);
  }
}

// Also states that do not lie on the lattice, and too few of them for its spacings.
TEST_CASE("on adaptive lattices regions have the label of every voxel's centre") {
  for (const int deepest : {1, 2, 3}) {
    AdaptiveLattice made(box, 4 * h);
    made.refine([](const LatticeLeaf& leaf) { return 0.3 * leaf.box.centre().norm() + 0.2 * h; }, deepest);
    const StateSpaceOptions options{.spacing = std::ldexp(4 * h, -deepest),
                                    .box = box,
                                    .lattice = std::make_shared<const AdaptiveLattice>(made)};
    std::vector<Vec3> corners;
    for (const AdaptiveLattice::Point& point : made.points()) corners.push_back(point.at);
    std::vector<Vec3> half(corners.begin(), corners.begin() + std::ptrdiff_t(corners.size() / 2));
    const std::vector<std::vector<Vec3>> cases{corners, half, scattered(900), scattered(40),
                                               lattice_with_gap()};
    for (std::size_t i = 0; i < cases.size(); ++i) {
      INFO("levels " << deepest << " case " << i);
      const StateSpace space = space_of(cases[i], options);
      const Regions regions(cases[i], options);
      const VoxelGrid grid(box, options.spacing / 4);
      std::size_t different = 0;
      ByLabel<std::size_t> of{};
      for (std::int32_t z = 0; z < grid.count[2]; ++z)
        for (std::int32_t y = 0; y < grid.count[1]; ++y)
          for (std::int32_t x = 0; x < grid.count[0]; ++x) {
            const Vec3 q = grid.centre({x, y, z});
            ++of[regions.label_at(q)];
            different += regions.label_at(q) != space.label(q) ? 1 : 0;
          }
      CHECK(different == 0);
      if (i == 0) CHECK(of[Label::safe] > 0);
    }
  }
}

// 90 thousand states fill several blocks; their labels are those of the states' own triangulation.
TEST_CASE("blocks meet without a seam, for any number of threads",
          SLOW("makes regions of a hundred thousand states")) {
  const double spacing = 0.0018;
  const std::vector<Vec3> states = scattered(90'000);
  const StateSpaceOptions options{.spacing = spacing, .box = box};
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const Regions one(states, options);
  const RegionSummary alone = one.summary();
  omp_set_num_threads(3);
  const Regions three(states, options);
  CHECK(same_bits(alone, three.summary()));
  CHECK(one.fill_distance() == three.fill_distance());
  CHECK(one.largest_hole()->centre == three.largest_hole()->centre);
  omp_set_num_threads(before);
  const StateSpace space = space_of(states, options);
  Places places;
  std::size_t different = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 q = places.uniform(0.04);
    different += one.label_at(q) != space.region_label(q) ? 1 : 0;
  }
  CHECK(different == 0);
}

TEST_CASE("regions without states are blank, and their fill distance infinite") {
  const Regions regions({}, {.spacing = h, .box = box});
  CHECK(regions.label_at(Vec3::Zero()) == Label::blank);
  CHECK(std::isinf(regions.fill_distance()));
  CHECK_FALSE(regions.largest_hole());
}
