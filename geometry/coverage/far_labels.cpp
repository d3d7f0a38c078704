#include "geometry/coverage/far_labels.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/coverage/cell_raster.hpp"

namespace forefeel {
namespace {

constexpr std::int32_t root_width = 32;  // [voxels]

class FarLabels {
 public:
  FarLabels(const PointOctree& points, std::span<const Vec3> at, const Thresholds& limits,
            VoxelLabels& voxels)
      : points_(points), at_(at), limits_(limits), voxels_(voxels), query_(points, none_), proof_(points) {}

  void resolve(const Voxel& low, std::int32_t width) {
    Voxel end{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      end[axis] = static_cast<std::int32_t>(std::min<std::int64_t>(low[axis] + width, voxels_.count[axis]));
    if (!any_unset(low, end)) return;
    if (width == 1) return fill(low, end, label_of(voxels_.centre_of(low[0], low[1], low[2])));
    const VoxelGrid& grid = voxels_.grid;
    const Vec3 q = grid.middle(low, width);
    const double e = grid.reach(low, width) * (1 + 1e-9), tiny = 1e-9 * grid.side;
    const PointOctree::Neighbour nearest = points_.nearest(q);
    if (nearest.id == PointOctree::nobody) return fill(low, end, Label::blank);
    if (std::sqrt(nearest.squared) > limits_.sparse_distance + e + tiny) {
      Vec3 axis = Vec3::Zero();
      if (const auto label = proof_.label(limits_, q, e, at_[nearest.id] - q, axis))
        return fill(low, end, *label);
    } else if (std::sqrt(nearest.squared) + e + tiny <= limits_.sparse_distance) {
      return fill(low, end, Label::sparse);
    }
    const std::int32_t half = width / 2;
    for (int child = 0; child < 8; ++child) {
      const Voxel part{low[0] + (child & 1 ? half : 0), low[1] + (child & 2 ? half : 0),
                       low[2] + (child & 4 ? half : 0)};
      if (part[0] < end[0] && part[1] < end[1] && part[2] < end[2]) resolve(part, half);
    }
  }

 private:
  template <class Visit>
  void for_each_row(const Voxel& low, const Voxel& end, Visit&& visit) const {
    for (std::int64_t k = low[2]; k < end[2]; ++k)
      for (std::int64_t j = low[1]; j < end[1]; ++j) {
        std::uint8_t* const row = voxels_.label.data() + voxels_.index(low[0], j, k);
        if (visit(row, row + (end[0] - low[0]))) return;
      }
  }
  bool any_unset(const Voxel& low, const Voxel& end) const {
    bool any = false;
    for_each_row(low, end, [&](const std::uint8_t* first, const std::uint8_t* last) {
      return any = std::find(first, last, mark::unset) != last;
    });
    return any;
  }
  void fill(const Voxel& low, const Voxel& end, Label label) {
    for_each_row(low, end, [&](std::uint8_t* first, std::uint8_t* last) {
      std::replace(first, last, mark::unset, static_cast<std::uint8_t>(label));
      return false;
    });
  }
  Label label_of(const Vec3& q) const {
    if (points_.nearest(q, limits_.sparse_distance).id != PointOctree::nobody) return Label::sparse;
    return query_.enclosed(q, limits_.gap_radius, limits_.gap_cos, limits_.merge) ? Label::gap : Label::blank;
  }

  const PointOctree& points_;
  std::span<const Vec3> at_;
  const Thresholds& limits_;
  VoxelLabels& voxels_;
  DelaunayIndex none_;
  CoverageQuery query_;
  FarProof proof_;
};

}  // namespace

void label_far(const PointOctree& points, std::span<const Vec3> at, const Thresholds& limits,
               VoxelLabels& voxels) {
  std::array<std::int64_t, 3> roots{};
  for (std::size_t axis = 0; axis < 3; ++axis) roots[axis] = (voxels.count[axis] - 1) / root_width + 1;
#pragma omp parallel
  {
    FarLabels labels(points, at, limits, voxels);
#pragma omp for schedule(dynamic, 8)
    for (std::int64_t r = 0; r < roots[0] * roots[1] * roots[2]; ++r)
      labels.resolve({static_cast<std::int32_t>(r % roots[0]) * root_width,
                      static_cast<std::int32_t>(r / roots[0] % roots[1]) * root_width,
                      static_cast<std::int32_t>(r / roots[0] / roots[1]) * root_width},
                     root_width);
  }
}

}  // namespace forefeel
