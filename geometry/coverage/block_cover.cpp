#include "geometry/coverage/block_cover.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/coverage/fill_distance.hpp"
#include "geometry/index/morton_order.hpp"

namespace forefeel {
namespace {

constexpr double touching = 1e-9;  // relative width of the shell of a ball where rounding decides

double beyond(const Box& box, const Box& other) {
  return (other.low - box.high).cwiseMax(box.low - other.high).cwiseMax(0.0).norm();
}

bool holds(const Box& box, const Vec3& centre, double radius) {
  return (centre.array() - radius > box.low.array()).all() &&
         (centre.array() + radius < box.high.array()).all();
}

// Corners to the circumcentre; not finite where the cell is flat.
Vec3 circumcentre(const std::array<Vec3, 4>& at) {
  const Vec3 a = at[1] - at[0], b = at[2] - at[0], c = at[3] - at[0];
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), cc = c.squaredNorm();
  return at[0] + (aa * b.cross(c) + bb * c.cross(a) + cc * a.cross(b)) / (2 * a.dot(b.cross(c)));
}

}  // namespace

// The states within reach of the block. The cells around a state of even density seldom reach beyond 2.5 mean
// distances.
void BlockCover::gather(const CoverBlock& block) {
  const VoxelGrid& grid = task_.voxels.grid;
  const Vec3 low = grid.low_of(block.low), high = grid.low_of(block.high);
  const double apart =
      std::cbrt((high - low).prod() / static_cast<double>(std::max<std::size_t>(block.states(), 1)));
  const double cone = task_.limits.safe_radius * (1 + 1e-6) + 2 * grid.side;
  const double reach = std::max(cone, std::min(2.5 * apart, 0.5 * (high - low).maxCoeff()));
  known_ = {low - Vec3::Constant(reach), high + Vec3::Constant(reach)};
  ++runs_;
  local_.clear();
  for (const CoverBlock& other : task_.blocks) {
    if (other.states() == 0 || beyond(known_, other.extent) > 0) continue;
    for (std::size_t i = other.first; i < other.last; ++i)
      if (known_.contains(task_.states.at[task_.order[i]])) {
        local_.push_back(task_.order[i]);
        seen_[task_.order[i]] = runs_;
      }
  }
}

void BlockCover::triangulate() {
  std::vector<Vec3> at;
  at.reserve(local_.size());
  for (const std::uint32_t i : local_) at.push_back(task_.states.at[i]);
  const double apart =
      std::cbrt((known_.size()).prod() / static_cast<double>(std::max<std::size_t>(at.size(), 1)));
  std::vector<std::uint32_t> sorted;
  sorted.reserve(at.size());
  for (const std::uint32_t i : morton_order(at, known_, apart)) sorted.push_back(local_[i]);
  local_ = std::move(sorted);
  delaunay_ = std::make_unique<DelaunayIndex>();
  walk_ = {};
  StateId last;
  for (std::uint32_t i = 0; i < local_.size(); ++i)
    last = delaunay_->insert({i}, task_.states.at[local_[i]], last);
}

// A state in the ball that is not triangulated. Those in the shell count as inside; the triangulation is exact.
bool BlockCover::foreign(const Vec3& centre, double radius, std::uint32_t& state) const {
  const PointOctree::Neighbour nearest = task_.states.points.nearest(centre, radius * (1 - touching));
  state = nearest.id;
  if (state != PointOctree::nobody && seen_[state] != runs_) return true;
  state = PointOctree::nobody;
  task_.states.points.for_each_within(centre, radius * (1 + touching),
                                      [&](std::uint32_t id, const Vec3&, double) {
                                        if (seen_[id] != runs_) state = std::min(state, id);
                                      });
  return state != PointOctree::nobody;
}

// Adds a state of the ball of this cell; false if the cell is one of all states.
bool BlockCover::extend(const Spread& spread) {
  const Vec3 centre = circumcentre(spread.at);
  std::uint32_t state = PointOctree::nobody;
  if (!centre.allFinite() || !foreign(centre, (centre - spread.at[0]).norm(), state)) return false;
  seen_[state] = runs_;
  local_.push_back(state);
  delaunay_->insert({static_cast<std::uint32_t>(local_.size() - 1)}, task_.states.at[state],
                    spread.states[0]);
  walk_.near = spread.states[0];
  return true;
}

std::uint8_t BlockCover::mark_at(const Vec3& q) {
  const CoverageQuery query(task_.states.points, *delaunay_);
  for (;;) {
    const Spread spread = delaunay_->spread(q, walk_);
    if (!spread.inside || !query.safe_cone(q, spread, task_.limits)) break;
    if (spread.spread <= task_.limits.safe_spread) return mark::safe;
    if (!extend(spread)) break;
  }
  return task_.states.points.nearest(q, task_.limits.sparse_distance).id != PointOctree::nobody ? mark::sparse
                                                                                                : mark::unset;
}

// Voxels of one brick share the states around it.
void BlockCover::answer_brick(std::span<const std::size_t> asked) {
  const auto place = [&](std::size_t index) {
    const Voxel v = task_.voxels.voxel(index);
    return task_.voxels.centre_of(v[0], v[1], v[2]);
  };
  Box box{place(asked.front()), place(asked.front())};
  for (const std::size_t index : asked)
    box = {box.low.cwiseMin(place(index)), box.high.cwiseMax(place(index))};
  around_.clear();
  task_.states.points.for_each_within(
      box.centre(), task_.limits.safe_radius + (0.5 + 1e-9) * box.size().norm(),
      [&](std::uint32_t id, const Vec3&, double) { around_.push_back(task_.states.at[id]); });
  for (const std::size_t index : asked) {
    const Vec3 q = place(index);
    if (task_.voxels.label[index] == mark::ask) {
      task_.voxels.label[index] = mark_at(q);
      continue;
    }
    directions_.clear();
    for (const Vec3& at : around_) {
      const double squared = (at - q).squaredNorm();
      if (squared <= task_.limits.safe_radius * task_.limits.safe_radius &&
          squared > task_.limits.merge * task_.limits.merge)
        directions_.push((at - q) / std::sqrt(squared));
    }
    task_.voxels.label[index] =
        solver_.at_most(directions_, task_.limits.safe_cos) ? mark::safe : mark::sparse;
  }
}

void BlockCover::answer(std::vector<std::size_t>& asked) {
  const auto brick = [&](std::size_t index) {
    const Voxel v = task_.voxels.voxel(index);
    return task_.voxels.index(v[0] / 4, v[1] / 4, v[2] / 4);
  };
  std::vector<std::pair<std::size_t, std::size_t>> sorted;
  sorted.reserve(asked.size());
  for (const std::size_t index : asked) sorted.emplace_back(brick(index), index);
  std::ranges::sort(sorted);
  for (std::size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
    while (end < sorted.size() && sorted[end].first == sorted[begin].first) ++end;
    asked.clear();
    for (std::size_t i = begin; i < end; ++i) asked.push_back(sorted[i].second);
    answer_brick(asked);
  }
}

void BlockCover::keep_balls(std::vector<EmptyBall>& balls, BlockFindings& found) {
  std::ranges::make_heap(balls, smaller);
  if (!balls.empty()) found.fill = balls.front().radius;
  while (!balls.empty()) {
    std::ranges::pop_heap(balls, smaller);
    found.balls.push_back(balls.back());
    balls.pop_back();
    if (delaunay_->spread(found.balls.back().centre, walk_).inside) return;
  }
}

void BlockCover::label(CellRaster& raster, const CoverBlock& block, BlockFindings& found) {
  std::vector<char> open(local_.size(), delaunay_->dimension() < 3), own(local_.size(), 0);
  std::vector<EmptyBall> balls;
  for (const StateId id : delaunay_->hull_states()) open[id.value] = 1;
  std::vector<std::uint32_t> mine(task_.order.begin() + block.first, task_.order.begin() + block.last);
  std::ranges::sort(mine);
  for (std::size_t i = 0; i < local_.size(); ++i) own[i] = std::ranges::binary_search(mine, local_[i]);
  for (const DelaunayIndex::Cell& cell : delaunay_->cells()) {
    std::array<Vec3, 4> at;
    bool mine_too = false;
    for (std::size_t i = 0; i < 4; ++i) {
      at[i] = task_.states.at[local_[cell.states[i].value]];
      mine_too = mine_too || own[cell.states[i].value];
    }
    const bool meets = raster.meets(at), whole = std::isfinite(cell.circumradius);
    if (!meets && !mine_too) continue;
    const double shell = cell.circumradius * (1 + touching);
    std::uint32_t other = PointOctree::nobody;
    const bool exact =
        whole && (holds(known_, cell.centre, shell) || !foreign(cell.centre, cell.circumradius, other));
    if (!exact)
      for (const StateId id : cell.states) open[id.value] = 1;
    if (exact && task_.voxels.grid.box.contains(cell.centre))
      balls.push_back({cell.circumradius, cell.centre});
    if (meets) raster.add(at, exact);
  }
  for (std::size_t i = 0; i < local_.size(); ++i)
    if (own[i] && open[i]) found.open.push_back(local_[i]);
  for (const std::uint32_t i : mine)
    if (seen_[i] != runs_) found.open.push_back(i);
  keep_balls(balls, found);
}

BlockFindings BlockCover::run(std::size_t number) {
  const CoverBlock& block = task_.blocks[number];
  BlockFindings found;
  gather(block);
  triangulate();
  CellRaster raster(task_.voxels, task_.limits, block.low, block.high, 0x1p-46 * task_.states.largest);
  label(raster, block, found);
  answer(raster.asked());
  delaunay_.reset();
  return found;
}

}  // namespace forefeel
