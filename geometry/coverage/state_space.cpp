#include "geometry/coverage/state_space.hpp"

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

double estimate_spacing(std::span<const State> states) {
  constexpr std::size_t most_measured = 20'000, around = 24;
  PointOctree points;
  std::vector<Vec3> positions;
  std::vector<PointOctree::Neighbour> near;
  for (const State& state : states) {
    if (!positions.empty()) points.nearest(state.at, 1, near);
    if (!near.empty() && near[0].squared == 0) continue;
    points.insert(static_cast<std::uint32_t>(positions.size()), state.at);
    positions.push_back(state.at);
  }
  std::vector<double> distance, radius;
  std::vector<Vec3> offsets;
  const std::size_t step = 1 + positions.size() / most_measured;
  for (std::size_t i = 0; i < positions.size(); i += step) {
    points.nearest(positions[i], around, near);
    if (near.size() < 2) continue;
    distance.push_back(std::sqrt(near[1].squared));
    const Vec3 q = positions[i] + half_way(i, distance.back());
    offsets.clear();
    for (const PointOctree::Neighbour& n : near) offsets.push_back(positions[n.id] - q);
    const LocalSpread cell = least_spread(offsets, distance.back());
    if (!cell.solid) continue;
    std::array<Vec3, 4> corner;
    for (std::size_t k = 0; k < 4; ++k) corner[k] = offsets[cell.corner[k]];
    radius.push_back(circumradius(corner));
  }
  // Strokes and shells have hardly a cell among near states.
  if (3 * radius.size() < distance.size()) return median(std::move(distance));
  return quantile_of(std::move(radius), 0.75) / (std::sqrt(3.0) / 2);
}

}  // namespace forefeel
