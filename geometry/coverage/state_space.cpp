#include "geometry/coverage/state_space.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/coverage/coverage_query.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/voxels.hpp"
#include "geometry/index/adaptive_lattice.hpp"
#include "geometry/index/local_spread.hpp"

namespace forefeel {

struct StateSpace::Impl {
  StateSpaceOptions options;
  std::vector<State> states;
  PointOctree points;
  DelaunayIndex delaunay;
  Thresholds limits;
  VoxelGrid voxels;  // of the regions
  StateId last;      // of the last insert(): the next state is often close

  explicit Impl(StateSpaceOptions given)
      : options(std::move(given)),
        limits(options.coverage, options.spacing, options.merge_distance * options.spacing),
        voxels(options.box, options.spacing / 4) {}

  double spacing_at(const Vec3& q) const {
    return options.lattice ? options.lattice->spacing_at(q) : options.spacing;
  }
  Thresholds limits_at(const Vec3& q) const {
    return options.lattice ? limits.scaled(options.lattice->spacing_at(q) / options.spacing) : limits;
  }
  // A state near q, to start the search from: the last one inserted if it is close, else the nearest.
  StateId hint(const Vec3& q) const {
    if (last.valid() && (states[last.value].at - q).squaredNorm() < 9 * options.spacing * options.spacing)
      return last;
    return {points.nearest(q).id};
  }
};

StateSpace::StateSpace(StateSpaceOptions options) {
  check_options(options);
  impl_ = std::make_unique<Impl>(std::move(options));
}
StateSpace::~StateSpace() = default;
StateSpace::StateSpace(StateSpace&&) noexcept = default;
StateSpace& StateSpace::operator=(StateSpace&&) noexcept = default;

const StateSpaceOptions& StateSpace::options() const {
  return impl_->options;
}
std::size_t StateSpace::size() const {
  return impl_->states.size();
}
const State& StateSpace::operator[](StateId id) const {
  return impl_->states[id.value];
}
const DelaunayIndex& StateSpace::delaunay() const {
  return impl_->delaunay;
}
const PointOctree& StateSpace::points() const {
  return impl_->points;
}

namespace {

void check(const State& state) {
  if (!state.usable())
    throw InputError("state", "its solve ended as " + std::string(name(state.solve.status)) +
                                  ", expected one that converged or was measured");
  if (!state.at.allFinite()) throw InputError("state", "its position is not finite, expected metres");
  if (!state.force.allFinite() && !state.force.array().isNaN().all())
    throw InputError("state", "its force is not finite, expected newtons, or NaN in all three if not known");
}

}  // namespace

StateSpace::Insertion StateSpace::insert(State state) {
  check(state);
  Impl& my = *impl_;
  if (const StateId known = find(state.at); known.valid()) return {known, false};
  const StateId id{static_cast<std::uint32_t>(my.states.size())};
  const StateId placed = my.delaunay.insert(id, state.at, my.hint(state.at));
  if (placed != id) return {placed, false};
  my.points.insert(id.value, state.at);
  my.states.push_back(std::move(state));
  my.last = id;
  return {id, true};
}

Coverage StateSpace::coverage(const Vec3& q) const {
  return CoverageQuery(impl_->points, impl_->delaunay).coverage(q, impl_->limits_at(q));
}

Label StateSpace::label(const Vec3& q) const {
  return CoverageQuery(impl_->points, impl_->delaunay).label(q, impl_->hint(q), impl_->limits_at(q));
}

Label StateSpace::label(const Vec3& q, PathWalk& walk) const {
  const CoverageQuery query(impl_->points, impl_->delaunay);
  if (!walk.near.valid()) walk.near = impl_->hint(q);
  return impl_->options.lattice ? query.label(q, walk, impl_->limits_at(q))
                                : query.label(q, walk, impl_->limits);
}

Label StateSpace::region_label(const Vec3& q) const {
  return label(impl_->options.box.contains(q) ? impl_->voxels.centre(impl_->voxels.voxel_of(q)) : q);
}

double StateSpace::spacing_at(const Vec3& q) const {
  return impl_->spacing_at(q);
}

void StateSpace::nearest(const Vec3& q, std::size_t n, std::vector<StateId>& out) const {
  impl_->points.nearest(q, n, out);
}

void StateSpace::within(const Vec3& q, double radius, std::vector<StateId>& out) const {
  impl_->points.within(q, radius, out);
}

StateId StateSpace::find(const Vec3& q) const {
  return {impl_->points.nearest(q, impl_->limits.merge).id};
}

Regions StateSpace::regions(const std::function<void(double)>& progress) const {
  std::vector<Vec3> at;
  at.reserve(impl_->states.size());
  for (const State& state : impl_->states) at.push_back(state.at);
  return Regions(std::move(at), impl_->options, progress);
}

std::vector<Vec3> lattice(const Box& box, double spacing) {
  // A corner that is a lattice point within rounding belongs to the lattice.
  const auto first = [&](int axis) { return static_cast<long>(std::ceil(box.low[axis] / spacing - 1e-9)); };
  const auto last = [&](int axis) { return static_cast<long>(std::floor(box.high[axis] / spacing + 1e-9)); };
  struct Entry {
    long squared, z, y, x;
    auto operator<=>(const Entry&) const = default;
  };
  std::vector<Entry> entries;
  for (long z = first(2); z <= last(2); ++z)
    for (long y = first(1); y <= last(1); ++y)
      for (long x = first(0); x <= last(0); ++x) entries.push_back({x * x + y * y + z * z, z, y, x});
  std::sort(entries.begin(), entries.end());
  std::vector<Vec3> result;
  result.reserve(entries.size());
  for (const Entry& e : entries)
    result.emplace_back(static_cast<double>(e.x) * spacing, static_cast<double>(e.y) * spacing,
                        static_cast<double>(e.z) * spacing);
  return result;
}

namespace {

// An offset half as long as the distance, in the i-th of directions spread evenly (Roberts' R2 sequence).
Vec3 half_way(std::size_t i, double distance) {
  const double turn = 2 * M_PI * std::fmod(0.5698402909980532 * static_cast<double>(i), 1.0);
  const double z = 2 * std::fmod(0.7548776662466927 * static_cast<double>(i), 1.0) - 1;
  const double across = std::sqrt(1 - z * z);
  return 0.5 * distance * Vec3(across * std::cos(turn), across * std::sin(turn), z);
}

}  // namespace

namespace {

constexpr std::size_t most_measured = 20'000, around = 24;

// The states at places of their own, and those near them.
struct Cloud {
  std::vector<Vec3> positions;
  PointOctree points;
  std::size_t step = 1;  // every step-th is measured

  explicit Cloud(std::span<const State> states) {
    positions.reserve(states.size());
    for (const State& state : states) positions.push_back(state.at);
    points = distinct_points(positions, 0);
    step += positions.size() / most_measured;
  }
};

// 1, 2 or 3, by the variances of the neighbours along their principal axes.
int local_dimension(const std::vector<Vec3>& offsets) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& d : offsets) mean += d / static_cast<double>(offsets.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& d : offsets) spread += (d - mean) * (d - mean).transpose();
  const Vec3 variance = Eigen::SelfAdjointEigenSolver<Mat3>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  constexpr double thin = 0.02;
  return variance[1] < thin * variance[2] ? 1 : variance[0] < thin * variance[2] ? 2 : 3;
}

// What the states near each measured one tell; NaN where they do not.
struct NearStates {
  std::vector<double> nearest, second, fourth, radius;  // distances, and of the cells [m]
  std::array<std::size_t, 4> of_dimension{};

  explicit NearStates(const Cloud& cloud) {
    const std::size_t measured = (cloud.positions.size() + cloud.step - 1) / cloud.step;
    for (std::vector<double>* values : {&nearest, &second, &fourth, &radius})
      values->assign(measured, unknown);
    std::vector<int> dimensions(measured, 0);
#pragma omp parallel for schedule(dynamic, 64)
    for (std::size_t k = 0; k < measured; ++k) look(cloud, k, dimensions[k]);
    for (const int dimension : dimensions) ++of_dimension[static_cast<std::size_t>(dimension)];
    std::erase_if(radius, [](double r) { return std::isnan(r); });
  }
  void look(const Cloud& cloud, std::size_t measured, int& dimension) {
    thread_local std::vector<PointOctree::Neighbour> near;
    const std::size_t i = measured * cloud.step;
    const Vec3& at = cloud.positions[i];
    cloud.points.nearest(at, around, near);
    if (near.size() < 2) return;
    const auto distance = [&](std::size_t k) {
      return std::sqrt(near[std::min(k, near.size() - 1)].squared);
    };
    nearest[measured] = distance(1);
    second[measured] = distance(2);
    fourth[measured] = distance(4);
    const Vec3 q = at + half_way(i, nearest[measured]);
    std::vector<Vec3> offsets;
    for (const PointOctree::Neighbour& n : near) offsets.push_back(cloud.positions[n.id] - q);
    dimension = local_dimension(offsets);
    const LocalSpread cell = least_spread(offsets, nearest[measured]);
    if (!cell.solid) return;
    std::array<Vec3, 4> corner;
    for (std::size_t k = 0; k < 4; ++k) corner[k] = offsets[cell.corner[k]];
    radius[measured] = circumradius(corner);
  }
  int dimension() const {
    const std::size_t all = of_dimension[1] + of_dimension[2] + of_dimension[3];
    if (2 * of_dimension[1] > all) return 1;
    return 2 * (of_dimension[1] + of_dimension[2]) > all ? 2 : 3;
  }
};

}  // namespace

EstimatedSpacing estimated_spacing(std::span<const State> states) {
  NearStates near{Cloud(states)};
  const int dimension = near.dimension();
  if (dimension == 1) return {median(std::move(near.second)), 1};
  if (dimension == 2) return {median(std::move(near.fourth)), 2};
  if (near.radius.empty()) return {median(std::move(near.nearest)), 3};
  return {quantile_of(std::move(near.radius), 0.75) / (std::sqrt(3.0) / 2), 3};
}

double estimate_spacing(std::span<const State> states) {
  return estimated_spacing(states).spacing;
}

}  // namespace forefeel
