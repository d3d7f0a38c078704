#include "geometry/coverage/voxel_runs.hpp"

#include <cstring>
#include <numeric>

namespace forefeel {

VoxelRuns::VoxelRuns(const VoxelLabels& voxels) : width_(static_cast<std::int32_t>(voxels.count[0])) {
  find_runs(voxels);
  connect(voxels);
  for (std::uint32_t run = 0; run < component_.size(); ++run) {  // those before it are numbered
    const std::uint32_t other = component_[run];
    component_[run] = other == run ? static_cast<std::uint32_t>(components_++) : component_[other];
  }
}

void VoxelRuns::find_runs(const VoxelLabels& voxels) {
  const auto rows = static_cast<std::size_t>(voxels.count[1] * voxels.count[2]);
  const auto width = static_cast<std::size_t>(width_);
  row_.assign(rows + 1, 0);
  const auto for_each_start = [&](std::size_t row, auto&& visit) {
    const std::uint8_t* const label = voxels.label.data() + row * width;
    for (std::size_t i = 0; i < width; ++i) {
      while (i > 0 && i + 8 <= width && std::memcmp(label + i, label + i - 1, 8) == 0) i += 8;
      if (i < width && (i == 0 || label[i] != label[i - 1])) visit(static_cast<std::int32_t>(i));
    }
  };
#pragma omp parallel for schedule(static)
  for (std::size_t row = 0; row < rows; ++row) for_each_start(row, [&](std::int32_t) { ++row_[row + 1]; });
  std::partial_sum(row_.begin(), row_.end(), row_.begin());
  start_.resize(row_.back());
  component_.resize(row_.back());
#pragma omp parallel for schedule(static)
  for (std::size_t row = 0; row < rows; ++row) {
    std::uint32_t run = row_[row];
    for_each_start(row, [&](std::int32_t i) {
      start_[run] = i;
      component_[run] = run;
      ++run;
    });
  }
}

std::uint32_t VoxelRuns::root(std::uint32_t run) {
  while (component_[run] != run) {
    component_[run] = component_[component_[run]];
    run = component_[run];
  }
  return run;
}

void VoxelRuns::join(const VoxelLabels& voxels, std::size_t a, std::size_t b) {
  const auto width = static_cast<std::size_t>(width_);
  for_each_overlap(a, b, [&](std::uint32_t ra, std::uint32_t rb, std::int32_t i) {
    const auto x = static_cast<std::size_t>(i);
    if (voxels.label[a * width + x] != voxels.label[b * width + x]) return;
    const std::uint32_t one = root(ra), other = root(rb);
    component_[std::max(one, other)] = std::min(one, other);
  });
}

// Each thread joins the runs of whole slabs of planes, then one thread joins the slabs.
void VoxelRuns::connect(const VoxelLabels& voxels) {
  const auto rows = static_cast<std::size_t>(voxels.count[1]),
             planes = static_cast<std::size_t>(voxels.count[2]);
  constexpr std::size_t slabs = 32;
  const auto first = [&](std::size_t slab) { return slab * planes / slabs; };
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t slab = 0; slab < slabs; ++slab)
    for (std::size_t k = first(slab); k < first(slab + 1); ++k)
      for (std::size_t j = 0; j < rows; ++j) {
        if (j > 0) join(voxels, k * rows + j - 1, k * rows + j);
        if (k > first(slab)) join(voxels, (k - 1) * rows + j, k * rows + j);
      }
  for (std::size_t slab = 1; slab < slabs; ++slab)
    if (const std::size_t k = first(slab); k > 0 && k < planes && first(slab - 1) < k)
      for (std::size_t j = 0; j < rows; ++j) join(voxels, (k - 1) * rows + j, k * rows + j);
}

}  // namespace forefeel
