#include "geometry/coverage/cell_raster.hpp"

#include <omp.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/index/adaptive_lattice.hpp"

namespace forefeel {

VoxelLimits::VoxelLimits(const StateSpaceOptions& options, const VoxelLabels& voxels)
    : all_{Thresholds(options.coverage, options.spacing, options.merge_distance * options.spacing)} {
  if (!options.lattice) return;
  const AdaptiveLattice& lattice = *options.lattice;
  level_.resize(voxels.label.size());
  int deepest = 0;
#pragma omp parallel for schedule(dynamic, 1) reduction(max : deepest)
  for (std::int64_t k = 0; k < voxels.count[2]; ++k)
    for (std::int64_t j = 0; j < voxels.count[1]; ++j)
      for (std::int64_t i = 0; i < voxels.count[0]; ++i) {
        const int level = std::ilogb(lattice.coarsest() / lattice.spacing_at(voxels.centre_of(i, j, k)));
        level_[voxels.index(i, j, k)] = static_cast<std::uint8_t>(level);
        deepest = std::max(deepest, level);
      }
  const Thresholds usual = all_[0];
  all_.clear();
  for (int level = 0; level <= deepest; ++level)
    all_.push_back(usual.scaled(std::ldexp(lattice.coarsest(), -level) / options.spacing));
}

const Thresholds* VoxelLimits::over(const VoxelLabels& voxels, const Voxel& low, const Voxel& end) const {
  if (level_.empty()) return &all_[0];
  const std::uint8_t first = level_[voxels.index(low[0], low[1], low[2])];
  for (std::int64_t k = low[2]; k < end[2]; ++k)
    for (std::int64_t j = low[1]; j < end[1]; ++j) {
      const std::uint8_t* const row = level_.data() + voxels.index(low[0], j, k);
      if (std::any_of(row, row + (end[0] - low[0]), [&](std::uint8_t level) { return level != first; }))
        return nullptr;
    }
  return &all_[first];
}

NearCubes::NearCubes(std::span<const Vec3> states, const VoxelLabels& voxels, double reach) {
  const VoxelGrid& grid = voxels.grid;
  Level level;
  for (std::size_t a = 0; a < 3; ++a) level.count[a] = ((voxels.count[a] - 1) >> finest) + 1;
  level.near.assign(static_cast<std::size_t>(level.count[0] * level.count[1] * level.count[2]), 0);
  const Vec3 around = Vec3::Constant(reach);
  for (const Vec3& at : states) {
    if ((at + around - grid.box.low).minCoeff() < 0 || (grid.box.high - at + around).minCoeff() < 0) continue;
    const Voxel low = grid.voxel_of(at - around), high = grid.voxel_of(at + around);
    for (std::int32_t k = low[2] >> finest; k <= high[2] >> finest; ++k)
      for (std::int32_t j = low[1] >> finest; j <= high[1] >> finest; ++j)
        for (std::int32_t i = low[0] >> finest; i <= high[0] >> finest; ++i)
          level.near[level.index({i, j, k})] = 1;
  }
  levels_.push_back(std::move(level));
  while (levels_.back().near.size() > 1) {
    const Level& fine = levels_.back();
    Level coarse;
    for (std::size_t a = 0; a < 3; ++a) coarse.count[a] = (fine.count[a] + 1) / 2;
    coarse.near.assign(static_cast<std::size_t>(coarse.count[0] * coarse.count[1] * coarse.count[2]), 0);
    for (std::int32_t k = 0; k < fine.count[2]; ++k)
      for (std::int32_t j = 0; j < fine.count[1]; ++j)
        for (std::int32_t i = 0; i < fine.count[0]; ++i)
          coarse.near[coarse.index({i / 2, j / 2, k / 2})] |= fine.near[fine.index({i, j, k})];
    levels_.push_back(std::move(coarse));
  }
}

namespace {

constexpr std::int64_t large_cell = 4096;  // voxels in the box of its corners
constexpr double in_cell = 1e-10;          // a weight above minus this may belong to a place in the cell
constexpr double thin = 1e-5;    // relative height of cells whose weights rounding may change by more
constexpr double unsure = 1e-7;  // relative doubt of pi^2 and of distances

double squared_longest(const std::array<Vec3, 4>& c) {
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j) longest = std::max(longest, (c[i] - c[j]).squaredNorm());
  return longest;
}

}  // namespace

bool CellRaster::meets(const std::array<Vec3, 4>& corners) {
  const VoxelGrid& grid = voxels_.grid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const double low = std::min({corners[0][a], corners[1][a], corners[2][a], corners[3][a]}),
                 high = std::max({corners[0][a], corners[1][a], corners[2][a], corners[3][a]});
    const double slack = 1e-6 * (high - low) + grain_, from = (low - slack - grid.origin[a]) / grid.side,
                 to = (high + slack - grid.origin[a]) / grid.side;
    if (!(from < high_[axis]) || !(to > low_[axis])) return false;
    // Centres lie half a side from the lower face; those of voxels that the box cuts, anywhere inside.
    first_[axis] = std::max(low_[axis], static_cast<std::int32_t>(std::max(0.0, std::floor(from))));
    end_[axis] = static_cast<std::int32_t>(std::min<double>(high_[axis], std::floor(to) + 1));
    const std::vector<double>& centre = voxels_.centre[axis];
    while (first_[axis] < end_[axis] && centre[static_cast<std::size_t>(first_[axis])] < low - slack)
      ++first_[axis];
    while (first_[axis] < end_[axis] && centre[static_cast<std::size_t>(end_[axis]) - 1] > high + slack)
      --end_[axis];
    if (first_[axis] >= end_[axis]) return false;
  }
  return true;
}

void CellRaster::set(std::size_t index, std::uint8_t value) {
  std::uint8_t& here = voxels_.label[index];
  const auto rank = [](std::uint8_t m) { return m == mark::unset ? 0 : m == mark::sparse ? 1 : m + 2; };
  if (rank(value) <= rank(here)) return;
  if (value >= mark::ask_cone && (here < mark::ask_cone || here == mark::unset)) asked_.push_back(index);
  here = value;
}

bool CellRaster::is_large() const {
  std::int64_t all = 1;
  for (std::size_t a = 0; a < 3; ++a) all *= end_[a] - first_[a];
  return all > large_cell;
}

// Adds the voxels from first_ to end_; of a large cell only those in near cubes.
template <class Keep, class Add>
void CellRaster::add_parts(Keep&& keep, Add&& add) {
  if (!is_large()) return add();
  const Voxel first = first_, end = end_;
  near_.for_each(first, end, keep, [&](const Voxel& low, std::int32_t width) {
    for (std::size_t a = 0; a < 3; ++a) {
      first_[a] = std::max(first[a], low[a]);
      end_[a] = std::min(end[a], low[a] + width);
    }
    add();
  });
}

// All voxels within the rounding of a cell that is (nearly) flat.
void CellRaster::add_flat(const std::array<Vec3, 4>& corners) {
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 n = (corners[(i + 1) % 4] - corners[i]).cross(corners[(i + 2) % 4] - corners[i]);
    if (n.squaredNorm() > normal.squaredNorm()) normal = n;
  }
  const bool plane = normal.norm() > 0;
  if (plane) normal.normalize();
  double from = 0, to = 0;
  for (const Vec3& c : corners) {
    from = std::min(from, normal.dot(c - corners[0]));
    to = std::max(to, normal.dot(c - corners[0]));
  }
  const double slack = 1e-6 * std::sqrt(squared_longest(corners)) + 8 * grain_;
  const VoxelGrid& grid = voxels_.grid;
  const auto keep = [&](const Voxel& low, std::int32_t width) {
    const double height = normal.dot(grid.middle(low, width) - corners[0]),
                 around = grid.reach(low, width) + grid.side;
    return height + around >= from - slack && height - around <= to + slack;
  };
  add_parts(keep, [&] {
    for (std::int32_t k = first_[2]; k < end_[2]; ++k)
      for (std::int32_t j = first_[1]; j < end_[1]; ++j)
        for (std::int32_t i = first_[0]; i < end_[0]; ++i) {
          const double height = normal.dot(voxels_.centre_of(i, j, k) - corners[0]);
          if (height >= from - slack && height <= to + slack) set(voxels_.index(i, j, k), mark::ask);
        }
  });
}

std::uint8_t CellRaster::mark_at(const Vec3& q, const Thresholds& limits) const {
  const Vec3 d = q - cell_.corner[0];
  double squared = 0, nearest = 1e300, farthest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double weight = (i == 0 ? 1.0 : 0.0) + cell_.slope[i].dot(d);
    const double away = (cell_.corner[i] - q).squaredNorm();
    squared += weight * away;
    nearest = std::min(nearest, away);
    farthest = std::max(farthest, away);
  }
  const double excess = squared - limits.safe_spread * limits.safe_spread;
  if (std::abs(excess) <= cell_.doubt) return mark::ask;
  if (excess > 0) {
    if (!cell_.exact) return mark::ask;
    const double near = limits.sparse_distance * limits.sparse_distance;
    return nearest < near * (1 - unsure) ? mark::sparse : mark::unset;
  }
  const bool encloses = limits.cell_suffices &&
                        farthest < limits.safe_radius * limits.safe_radius * (1 - unsure) &&
                        nearest > 4 * limits.merge * limits.merge;
  return encloses ? mark::safe : mark::ask_cone;
}

void CellRaster::add_row(std::int32_t j, std::int32_t k, double first, double last) {
  const std::vector<double>& x = voxels_.centre[0];
  const std::size_t row = voxels_.index(0, j, k);
  Vec3 q(0, voxels_.centre[1][static_cast<std::size_t>(j)], voxels_.centre[2][static_cast<std::size_t>(k)]);
  for (std::int32_t i = first_[0]; i < end_[0]; ++i) {
    q.x() = x[static_cast<std::size_t>(i)];
    if (q.x() > last) break;
    if (q.x() < first) continue;
    const std::size_t index = row + static_cast<std::size_t>(i);
    set(index, mark_at(q, limits_.at(index)));
  }
}

void CellRaster::add(const std::array<Vec3, 4>& corners, bool exact) {
  const Vec3 a = corners[1] - corners[0], b = corners[2] - corners[0], c = corners[3] - corners[0];
  const Vec3 bc = b.cross(c);
  const double volume = a.dot(bc), squared = squared_longest(corners), longest = std::sqrt(squared);
  if (!(volume > (thin * longest + 64 * grain_) * squared)) return add_flat(corners);
  cell_.corner = corners;
  cell_.exact = exact;
  cell_.doubt = unsure * std::max(squared, limits_.widest().safe_spread * limits_.widest().safe_spread);
  cell_.slope[1] = bc / volume;
  cell_.slope[2] = c.cross(a) / volume;
  cell_.slope[3] = a.cross(b) / volume;
  cell_.slope[0] = -cell_.slope[1] - cell_.slope[2] - cell_.slope[3];
  std::array<double, 4> inverse{};
  for (std::size_t i = 0; i < 4; ++i) inverse[i] = cell_.slope[i].x() != 0 ? 1 / cell_.slope[i].x() : 0;
  // A cube is beyond a face if the weight of its opposite corner is negative in all of it.
  const VoxelGrid& grid = voxels_.grid;
  const auto keep = [&](const Voxel& low, std::int32_t width) {
    const Vec3 d = grid.middle(low, width) - corners[0];
    const double around = grid.reach(low, width) + grid.side + 1e-6 * longest;
    for (std::size_t i = 0; i < 4; ++i)
      if ((i == 0 ? 1.0 : 0.0) + cell_.slope[i].dot(d) + cell_.slope[i].norm() * around < 0) return false;
    return true;
  };
  add_parts(keep, [&] { add_rows(inverse, grain_ + 1e-9 * longest); });
}

void CellRaster::add_rows(const std::array<double, 4>& inverse, double slack) {
  const std::array<Vec3, 4>& corners = cell_.corner;
  for (std::int32_t k = first_[2]; k < end_[2]; ++k)
    for (std::int32_t j = first_[1]; j < end_[1]; ++j) {
      const double dy = voxels_.centre[1][static_cast<std::size_t>(j)] - corners[0].y(),
                   dz = voxels_.centre[2][static_cast<std::size_t>(k)] - corners[0].z();
      double first = -1e300, last = 1e300;
      for (std::size_t i = 0; i < 4; ++i) {
        const double rest =
            (i == 0 ? 1.0 : 0.0) + cell_.slope[i].y() * dy + cell_.slope[i].z() * dz + in_cell;
        const double end = -rest * inverse[i];  // relative to corner 0
        if (cell_.slope[i].x() > 0)
          first = std::max(first, end);
        else if (cell_.slope[i].x() < 0)
          last = std::min(last, end);
        else if (rest < 0)
          last = -1e300;
      }
      if (first <= last + 2 * slack)
        add_row(j, k, corners[0].x() + first - slack, corners[0].x() + last + slack);
    }
}

}  // namespace forefeel
