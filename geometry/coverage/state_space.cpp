#include "geometry/coverage/state_space.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "geometry/common/error.hpp"
#include "geometry/coverage/coverage_query.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/voxel_grid.hpp"
#include "geometry/index/adaptive_lattice.hpp"

namespace forefeel {

struct StateSpace::Impl {
  StateSpaceOptions options;
  std::vector<State> states;
  PointOctree points;
  DelaunayIndex delaunay;
  Thresholds limits;
  VoxelGrid voxels;  // of the regions
  std::unique_ptr<Regions> regions;
  StateId last;  // of the last insert(): the next state is often close

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

void check_options(const StateSpaceOptions& options) {
  if (!(options.spacing > 0) || !std::isfinite(options.spacing))
    throw InputError("spacing",
                     "is " + std::to_string(options.spacing) + ", expected a positive length in metres");
  // A safe place is within kappa_s h of a state; regions need it to be at least sparse.
  if (!(options.coverage.sparse_distance >= options.coverage.safe_spread))
    throw InputError("coverage",
                     "the sparse distance is below the safe spread, expected it to be at least as large");
}

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
  if (my.regions) my.regions->inserted(my.states.back().at, my.delaunay.disturbed());
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

// All voxels of a leaf have the leaf's label, which is the label at their centres.
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

const Regions& StateSpace::regions() const {
  if (!impl_->regions)
    impl_->regions = std::make_unique<Regions>(impl_->points, impl_->delaunay, impl_->options);
  return *impl_->regions;
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

}  // namespace forefeel
