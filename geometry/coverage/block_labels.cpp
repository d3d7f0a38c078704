#include "geometry/coverage/block_labels.hpp"

#include <omp.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <memory>
#include <numeric>
#include <span>

#include "geometry/index/morton_order.hpp"

namespace forefeel {
namespace {

// ---- blocks of about equally many states, by cuts at medians

struct CoverBlock {
  Voxel low{}, high{};                // voxels from low to below high
  std::uint32_t first = 0, last = 0;  // its states: order[first] to below order[last]
  Box extent;  // of these states [m]; those outside the box belong to the nearest voxel
  std::size_t states() const { return last - first; }
};

constexpr std::size_t most_in_block = 60'000;
constexpr std::int64_t voxels_in_block = std::int64_t{1} << 25;

class Division {
 public:
  Division(const VoxelGrid& grid, std::span<const Vec3> states, std::vector<std::uint32_t>& order)
      : grid_(grid), states_(states), order_(order) {}

  void divide(CoverBlock block) {
    std::array<std::size_t, 3> axes{0, 1, 2};
    const auto width = [&](std::size_t axis) { return block.high[axis] - block.low[axis]; };
    std::ranges::sort(axes, std::greater(), width);
    const bool many = block.states() > most_in_block;
    const bool large = std::int64_t{width(0)} * width(1) * width(2) > voxels_in_block;
    if ((!many && !large) || width(axes[0]) == 1) return keep(block);
    const std::size_t axis = axes[0];
    const std::int32_t cut = many ? median(block, axis) : block.low[axis] + width(axis) / 2;
    const auto begin = order_.begin();
    const auto middle = std::stable_partition(begin + block.first, begin + block.last,
                                              [&](std::uint32_t i) { return voxel(i, axis) < cut; });
    CoverBlock upper = block;
    block.high[axis] = upper.low[axis] = cut;
    block.last = upper.first = static_cast<std::uint32_t>(middle - begin);
    divide(block);
    divide(upper);
  }
  std::vector<CoverBlock> blocks;

 private:
  std::int32_t voxel(std::uint32_t state, std::size_t axis) const {
    return grid_.voxel_of(states_[state])[axis];
  }
  // Between the first and the last voxel.
  std::int32_t median(const CoverBlock& block, std::size_t axis) {
    std::vector<std::int32_t> at;
    const std::size_t step = 1 + block.states() / 4096;
    for (std::size_t i = block.first; i < block.last; i += step) at.push_back(voxel(order_[i], axis));
    const auto middle = at.begin() + static_cast<std::ptrdiff_t>(at.size() / 2);
    std::ranges::nth_element(at, middle);
    return std::clamp(*middle, block.low[axis] + 1, block.high[axis] - 1);
  }
  void keep(CoverBlock& block) {
    for (std::size_t i = block.first; i < block.last; ++i) {
      const Vec3& at = states_[order_[i]];
      if (i == block.first) block.extent = {at, at};
      block.extent = {block.extent.low.cwiseMin(at), block.extent.high.cwiseMax(at)};
    }
    blocks.push_back(block);
  }

  const VoxelGrid& grid_;
  std::span<const Vec3> states_;
  std::vector<std::uint32_t>& order_;
};

// order: indices of the states; reordered so that the states of a block follow each other.
std::vector<CoverBlock> cover_blocks(const VoxelGrid& grid, std::span<const Vec3> states,
                                     std::vector<std::uint32_t>& order) {
  CoverBlock whole;
  whole.last = static_cast<std::uint32_t>(order.size());
  for (std::size_t axis = 0; axis < 3; ++axis) whole.high[axis] = static_cast<std::int32_t>(grid.count[axis]);
  Division division(grid, states, order);
  division.divide(whole);
  return std::move(division.blocks);
}

// ---- one block

// What the blocks share.
struct CoverTask {
  const CoveredStates& states;
  std::span<const CoverBlock> blocks;
  std::span<const std::uint32_t> order;  // of the states
  const VoxelLimits& limits;
  const NearCubes& near;
  VoxelLabels& voxels;
};

class BlockCover {
 public:
  explicit BlockCover(const CoverTask& task) : task_(task), seen_(task.states.at.size(), 0) {}
  // Sets the labels safe and sparse of the block's voxels, and mark::unset for the others.
  BlockFindings run(std::size_t block);

 private:
  void gather(const CoverBlock& block);
  void triangulate();
  void label(CellRaster& raster, const CoverBlock& block, BlockFindings& found);
  void keep_balls(std::vector<EmptyBall>& balls, BlockFindings& found);
  void answer(std::vector<std::size_t>& asked);
  void answer_brick(std::span<const std::size_t> asked);
  std::uint8_t mark_at(const Vec3& q, const Thresholds& limits);
  bool foreign(const Vec3& centre, double radius, std::uint32_t& state) const;
  bool extend(const Spread& spread);

  CoverTask task_;
  Box known_;                         // all states in it are triangulated [m]
  std::vector<std::uint32_t> local_;  // state of each number of the triangulation
  std::vector<std::uint32_t> seen_;   // by state: the last run that included it
  std::uint32_t runs_ = 0;

  std::unique_ptr<DelaunayIndex> delaunay_;
  PathWalk walk_;
  std::vector<Vec3> around_;  // states near a brick
  Directions directions_;
  ConeSolver solver_;
};

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

// The states within reach of the block. The cells around a state of even density seldom reach beyond 2.5 mean
// distances.
void BlockCover::gather(const CoverBlock& block) {
  const VoxelGrid& grid = task_.voxels.grid;
  const Vec3 low = grid.low_of(block.low), high = grid.low_of(block.high);
  const double apart =
      std::cbrt((high - low).prod() / static_cast<double>(std::max<std::size_t>(block.states(), 1)));
  const double cone = task_.limits.widest().safe_radius * (1 + 1e-6) + 2 * grid.side;
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
  walk_.version = 0;
  walk_.near = {};
  StateId last;
  for (std::uint32_t i = 0; i < local_.size(); ++i)
    last = delaunay_->insert({i}, task_.states.at[local_[i]], last);
}

// A state in the ball that is not triangulated. Those in the shell count as inside; the triangulation is exact. The
// ball of a cell holds no triangulated state but in its shell, so the search ends soon however many states it holds.
bool BlockCover::foreign(const Vec3& centre, double radius, std::uint32_t& state) const {
  state = task_.states.points.find_within(centre, radius * (1 + touching),
                                          [&](std::uint32_t id) { return seen_[id] != runs_; });
  return state != PointOctree::nobody;
}

// Adds a state of the ball of this cell; false if the cell is one of all states.
bool BlockCover::extend(const Spread& spread) {
  const Vec3 centre = circumcentre(spread.at);
  if (!centre.allFinite()) return false;
  const double radius = (centre - spread.at[0]).norm();
  std::uint32_t state = task_.states.points.nearest(centre, radius * (1 - touching)).id;
  if ((state == PointOctree::nobody || seen_[state] == runs_) && !foreign(centre, radius, state))
    return false;
  seen_[state] = runs_;
  local_.push_back(state);
  delaunay_->insert({static_cast<std::uint32_t>(local_.size() - 1)}, task_.states.at[state],
                    spread.states[0]);
  walk_.near = spread.states[0];
  return true;
}

std::uint8_t BlockCover::mark_at(const Vec3& q, const Thresholds& limits) {
  const CoverageQuery query(task_.states.points, *delaunay_);
  for (;;) {
    const Spread spread = delaunay_->spread(q, walk_);
    if (!spread.inside || !query.safe_cone(q, spread, limits)) break;
    if (spread.spread <= limits.safe_spread) return mark::safe;
    if (!extend(spread)) break;
  }
  return task_.states.points.nearest(q, limits.sparse_distance).id != PointOctree::nobody ? mark::sparse
                                                                                          : mark::unset;
}

// Voxels of one brick share the states around it.
void BlockCover::answer_brick(std::span<const std::size_t> asked) {
  const auto place = [&](std::size_t index) {
    const Voxel v = task_.voxels.voxel(index);
    return task_.voxels.centre_of(v[0], v[1], v[2]);
  };
  Box box{place(asked.front()), place(asked.front())};
  double radius = 0;
  for (const std::size_t index : asked) {
    box = {box.low.cwiseMin(place(index)), box.high.cwiseMax(place(index))};
    radius = std::max(radius, task_.limits.at(index).safe_radius);
  }
  around_.clear();
  task_.states.points.for_each_within(
      box.centre(), radius + (0.5 + 1e-9) * box.size().norm(),
      [&](std::uint32_t id, const Vec3&, double) { around_.push_back(task_.states.at[id]); });
  for (const std::size_t index : asked) {
    const Vec3 q = place(index);
    const Thresholds& limits = task_.limits.at(index);
    if (task_.voxels.label[index] == mark::ask) {
      task_.voxels.label[index] = mark_at(q, limits);
      continue;
    }
    directions_.clear();
    for (const Vec3& at : around_) {
      const double squared = (at - q).squaredNorm();
      if (squared <= limits.safe_radius * limits.safe_radius && squared > limits.merge * limits.merge)
        directions_.push((at - q) / std::sqrt(squared));
    }
    task_.voxels.label[index] = solver_.at_most(directions_, limits.safe_cos) ? mark::safe : mark::sparse;
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

bool smaller(const EmptyBall& a, const EmptyBall& b) {
  return a.radius < b.radius;
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
  CellRaster raster(task_.voxels, task_.limits, task_.near, block.low, block.high,
                    0x1p-46 * task_.states.largest);
  label(raster, block, found);
  answer(raster.asked());
  delaunay_.reset();
  return found;
}

// No exception may leave a parallel loop.
template <class Work>
void guarded(std::exception_ptr& failed, Work&& work) {
  try {
    work();
  } catch (...) {
#pragma omp critical(forefeel_label_blocks)
    if (!failed) failed = std::current_exception();
  }
}

}  // namespace

BlockFindings label_blocks(const CoveredStates& states, const VoxelLimits& limits, VoxelLabels& voxels,
                           const std::function<void(double)>& progress) {
  std::vector<std::uint32_t> order(states.at.size());
  std::iota(order.begin(), order.end(), 0u);
  const std::vector<CoverBlock> blocks = cover_blocks(voxels.grid, states.at, order);
  const double slack = 1e-6 * limits.widest().safe_spread + 0x1p-40 * states.largest;
  const NearCubes near(states.at, voxels, limits.widest().safe_spread + slack);
  std::vector<BlockFindings> found(blocks.size());
  std::exception_ptr failed;
  std::size_t done = 0;
#pragma omp parallel
  {
    BlockCover cover({states, blocks, order, limits, near, voxels});
#pragma omp for schedule(dynamic, 1)
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      guarded(failed, [&] { found[b] = cover.run(b); });
      std::size_t now = 0;
#pragma omp atomic capture
      now = ++done;
      if (progress && omp_get_thread_num() == 0)
        progress(static_cast<double>(now) / static_cast<double>(blocks.size()));
    }
  }
  if (failed) std::rethrow_exception(failed);
  BlockFindings all;
  for (const BlockFindings& f : found) {
    all.fill = std::max(all.fill, f.fill);
    all.balls.insert(all.balls.end(), f.balls.begin(), f.balls.end());
    all.open.insert(all.open.end(), f.open.begin(), f.open.end());
  }
  return all;
}

}  // namespace forefeel
