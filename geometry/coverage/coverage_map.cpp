#include "geometry/coverage/coverage_map.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <numeric>

#include "geometry/coverage/block_cover.hpp"
#include "geometry/coverage/bridge.hpp"
#include "geometry/coverage/far_labels.hpp"
#include "geometry/coverage/fill_distance.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/coverage/voxel_summary.hpp"
#include "geometry/index/morton_order.hpp"

namespace forefeel {
namespace {

// Along a Z-curve, without those that repeat an earlier one.
CoveredStates index_states(std::span<const Vec3> states, const Box& box, double spacing, double merge) {
  CoveredStates kept;
  kept.at.reserve(states.size());
  for (const std::uint32_t i : morton_order(states, box, spacing)) {
    const Vec3& at = states[i];
    if (kept.points.nearest(at, merge).id != PointOctree::nobody) continue;
    kept.points.insert(static_cast<std::uint32_t>(kept.at.size()), at);
    kept.at.push_back(at);
    kept.largest = std::max(kept.largest, at.cwiseAbs().maxCoeff());
  }
  return kept;
}

// No exception may leave a parallel loop.
template <class Work>
void guarded(std::exception_ptr& failed, Work&& work) {
  try {
    work();
  } catch (...) {
#pragma omp critical(forefeel_coverage_map)
    if (!failed) failed = std::current_exception();
  }
}

}  // namespace

struct CoverageMap::Impl {
  StateSpaceOptions options;
  Thresholds limits;
  CoveredStates states;
  VoxelLabels voxels;
  double fill = 0;
  std::vector<EmptyBall> balls;     // from large to small; the last is in the hull of the states
  std::vector<std::uint32_t> open;  // states at the hull or beside large cells
  DelaunayIndex large;              // of the open states: all cells that the blocks do not know

  Impl(std::span<const Vec3> at, const StateSpaceOptions& given)
      : options(given),
        limits(given.coverage, given.spacing, given.merge_distance * given.spacing),
        states(index_states(at, given.box, given.spacing, limits.merge)),
        voxels(given.box, given.spacing / 4, mark::unset) {}

  void cover(const std::function<void(double)>& progress);
  void add_large_cells();
};

void CoverageMap::Impl::cover(const std::function<void(double)>& progress) {
  std::vector<std::uint32_t> order(states.at.size());
  std::iota(order.begin(), order.end(), 0u);
  const std::vector<CoverBlock> blocks = cover_blocks(voxels.grid, states.at, order);
  std::vector<BlockFindings> found(blocks.size());
  std::exception_ptr failed;
  std::size_t done = 0;
#pragma omp parallel
  {
    BlockCover cover({states, blocks, order, limits, voxels});
#pragma omp for schedule(dynamic, 1)
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      guarded(failed, [&] { found[b] = cover.run(b); });
      std::size_t now = 0;
#pragma omp atomic capture
      now = ++done;
      if (progress && omp_get_thread_num() == 0)
        progress(0.9 * static_cast<double>(now) / static_cast<double>(blocks.size()));
    }
  }
  if (failed) std::rethrow_exception(failed);
  for (const BlockFindings& f : found) {
    fill = std::max(fill, f.fill);
    balls.insert(balls.end(), f.balls.begin(), f.balls.end());
    open.insert(open.end(), f.open.begin(), f.open.end());
  }
}

// The cells that no block was certain of have only open states as corners.
void CoverageMap::Impl::add_large_cells() {
  std::ranges::sort(open);
  StateId last;
  for (const std::uint32_t i : open) last = large.insert({i}, states.at[i], last);
  for (const EmptyBall& ball : empty_balls(large, options.box)) balls.push_back(ball);
  std::ranges::stable_sort(balls, std::greater(), &EmptyBall::radius);
  std::vector<EmptyBall> empty;
  StateId near;
  for (const EmptyBall& ball : balls) {
    if (states.points.nearest(ball.centre, ball.radius * (1 - 1e-9)).id != PointOctree::nobody) continue;
    fill = std::max(fill, ball.radius);
    empty.push_back(ball);
    const Spread spread = large.spread(ball.centre, near);
    near = spread.states[0];
    if (spread.inside) break;
  }
  balls = std::move(empty);
  open.clear();
}

CoverageMap::CoverageMap(std::vector<Vec3> states, const StateSpaceOptions& options,
                         const std::function<void(double)>& progress)
    : impl_(std::make_unique<Impl>(states, options)) {
  check_options(options);
  std::vector<Vec3>().swap(states);
  Impl& my = *impl_;
  my.cover(progress);
  my.add_large_cells();
  if (progress) progress(0.95);
  label_far(my.states.points, my.states.at, my.limits, my.voxels);
  if (progress) progress(1);
}
CoverageMap::~CoverageMap() = default;

Label CoverageMap::label_at(const Vec3& q) const {
  const Voxel v = impl_->voxels.grid.voxel_of(q);
  return static_cast<Label>(impl_->voxels.label[impl_->voxels.index(v[0], v[1], v[2])]);
}

RegionSummary CoverageMap::summary(bool with_leaves) const {
  const Impl& my = *impl_;
  const double kappa = my.options.coverage.sparse_distance, rim = rim_reach(kappa, my.options.spacing);
  RegionSummary result = summarise(
      my.voxels, [rim](const Vec3&) { return rim; }, with_leaves);
  find_sides(result.components, kappa, [&my](const Vec3& place, std::vector<Vec3>& offsets) {
    my.states.points.offsets_within(place, my.limits.gap_radius, offsets);
  });
  return result;
}

// delta has its maxima at Voronoi vertices (circumcentres of the cells) inside the box, or on its boundary.
double CoverageMap::fill_distance() const {
  const PointOctree& points = impl_->states.points;
  if (points.size() == 0) return std::numeric_limits<double>::infinity();
  return largest_in_box([&](const Vec3& q) { return std::sqrt(points.nearest(q).squared); },
                        impl_->options.box, impl_->fill, 4e-3 * impl_->voxels.grid.side);
}

std::optional<EmptyBall> CoverageMap::largest_hole() const {
  const Impl& my = *impl_;
  if (my.balls.empty() || !my.large.spread(my.balls.back().centre, {}).inside) return std::nullopt;
  return my.balls.back();
}

}  // namespace forefeel
