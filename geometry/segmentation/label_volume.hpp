#pragma once
// A label volume, a segmented image of a scanner: one whole number for each voxel, 0 for the background. The centre of
// voxel (i, j, k) lies at
//   x = origin + axes (i, j, k)^T                                                                             [m]
// so the columns of `axes` hold spacing and orientation. Coordinates are those of the file. NIfTI: right, anterior,
// superior. DICOM, and most .mha and .nrrd files: left, posterior, superior. `directions` names them. A negative size
// of a voxel counts as its absolute value, with a warning.
//
// Readers: NIfTI 1 and 2 in one file (.nii, .nii.gz; header interpreted by libnifti), MetaImage (.mha, .mhd), NRRD
// (.nrrd, .nhdr; raw, gzip or ascii), VTK XML image data (.vti). No reader trusts the header: before it allocates, it
// checks each size against the data in the file and against the available memory.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

struct LabelVolume {
  std::array<std::int64_t, 3> size{};      // voxels along i, j, k
  Mat3 axes = Mat3::Zero();                // column d: step from a voxel to the next along direction d [m]
  Vec3 origin = Vec3::Zero();              // centre of voxel (0, 0, 0) [m]
  std::vector<std::int64_t> values;        // the labels that occur, ascending; at most 65535
  std::vector<std::uint16_t> voxels;       // position in `values`; i runs fastest
  std::string unit = "mm";                 // of the file's lengths, as they were taken
  double metres = 1e-3;                    // of that unit [m]
  bool unit_given = false;                 // the file names it; otherwise mm are assumed
  std::string unit_unknown = {};           // what the file names, where that is no known unit
  std::string directions = {};             // where x, y and z point, as far as the file says
  std::vector<std::string> warnings = {};  // contradictions of the header

  std::size_t at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>(i + size[0] * (j + size[1] * k));
  }
  Vec3 position(const Vec3& index) const { return origin + axes * index; }
  double voxel_volume() const { return std::abs(axes.determinant()); }  // [m^3]
};

inline constexpr const char* label_volume_extensions = ".nii .nii.gz .mha .mhd .nrrd .nhdr .vti";
bool is_label_volume_file(const std::filesystem::path& file);  // by extension

// InputError names the file: unknown or damaged header, sizes that the data do not hold, values that are not whole
// numbers, more than 65535 different ones, axes without a volume, more voxels than memory is left for.
LabelVolume read_label_volume(const std::filesystem::path& file);

}  // namespace forefeel
