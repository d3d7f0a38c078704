// NIfTI 1 and 2, in one file. libnifti interprets the header; the data are read here, within what the file holds.

#include <fmt/format.h>
#include <nifti2_io.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/segmentation/raw_image.hpp"

namespace forefeel {
namespace {

using Image = std::unique_ptr<nifti_image, void (*)(nifti_image*)>;

[[noreturn]] void fail(const std::string& file, const std::string& problem) {
  throw InputError({.file = file}, problem);
}

std::optional<Scalar> scalar_of(int type) {
  constexpr std::array codes{NIFTI_TYPE_INT8,    NIFTI_TYPE_UINT8,  NIFTI_TYPE_INT16, NIFTI_TYPE_UINT16,
                             NIFTI_TYPE_INT32,   NIFTI_TYPE_UINT32, NIFTI_TYPE_INT64, NIFTI_TYPE_UINT64,
                             NIFTI_TYPE_FLOAT32, NIFTI_TYPE_FLOAT64};  // in the order of Scalar
  const auto* const found = std::ranges::find(codes, type);
  if (found == codes.end()) return {};
  return static_cast<Scalar>(found - codes.begin());
}

// Checks what libnifti does not check, or refuses with a message of its own: number of dimensions and sizes (of either
// version), type and place of the data.
template <class Header>
void check(Header header, bool swap, const std::string& file) {
  const auto plain = [&](auto value) { return swap ? byte_swapped(value) : value; };
  const auto dimensions = plain(header.dim[0]);
  if (dimensions < 1 || dimensions > 7) fail(file, "the header gives no number of dimensions from 1 to 7");
  for (int d = 1; d <= dimensions; ++d)
    if (plain(header.dim[d]) < 1) fail(file, "the header gives a size that is not positive");
  const int type = plain(header.datatype);
  if (!scalar_of(type))
    fail(file, fmt::format("data type {} is not read, expected whole or real numbers", type));
  const auto offset = static_cast<double>(plain(header.vox_offset));
  if (!(offset >= 0 && offset < 1e9))
    fail(file, fmt::format("the data begin at byte {:g}, outside the file", offset));
}

// The sizes of a voxel, made positive in the header, too: libnifti takes those that are not as 1, without a word.
template <class Header>
Vec3 positive_sizes(Header& header, bool swap, std::vector<std::string>& warnings) {
  const auto plain = [&](auto value) { return swap ? byte_swapped(value) : value; };
  Vec3 sizes = Vec3::Ones();
  for (int d = 1; d <= std::min<std::int64_t>(3, plain(header.dim[0])); ++d) {
    const auto size = plain(header.pixdim[d]);
    sizes[d - 1] = positive_size(static_cast<double>(size), fmt::format("pixdim[{}]", d), warnings);
    if (size < 0) header.pixdim[d] = plain(-size);
  }
  return sizes;
}

struct Read {
  Image image;
  Vec3 sizes;  // of a voxel, by pixdim
};

template <class Header>
Read image_of(const std::string& start, bool swap, const std::string& file,
              std::vector<std::string>& warnings, nifti_image* (*convert)(Header, const char*)) {
  Header header;
  if (start.size() < sizeof header) fail(file, "is shorter than its header, the file is cut short");
  std::memcpy(&header, start.data(), sizeof header);
  if (std::strncmp(header.magic, "n+", 2) != 0)
    fail(file, "is no NIfTI file with header and data in one (magic n+1 or n+2)");
  check(header, swap, file);
  const Vec3 sizes = positive_sizes(header, swap, warnings);
  nifti_set_debug_level(0);  // it would print
  Image image(convert(header, "labels.nii"), nifti_image_free);
  if (!image) fail(file, "the header is damaged");
  return {std::move(image), sizes};
}

Mat3 axes_of(const nifti_dmat44& m) {
  Mat3 axes;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) axes(r, c) = m.m[r][c];
  return axes;
}

std::string in_words(const Vec3& size) {
  return fmt::format("{:.4g} x {:.4g} x {:.4g}", size[0], size[1], size[2]);
}

// What sform, qform and pixdim say of the same voxels, where two of them differ by more than 1 %.
void compare_forms(const nifti_image& image, const Vec3& sizes, std::vector<std::string>& warnings) {
  const Mat3 s = axes_of(image.sto_xyz), q = axes_of(image.qto_xyz);
  const Vec3 of_s = s.colwise().norm().transpose();
  const auto differs = (of_s - sizes).array().abs() > 0.01 * of_s.cwiseMax(sizes).array();
  if ((differs && sizes.array() > 0).any()) {  // 0: pixdim does not say
    warnings.push_back(
        fmt::format("sform gives voxels of {}, pixdim{} {}: sform was taken; if the body has the wrong size, "
                    "its sform holds "
                    "directions alone",
                    in_words(of_s), image.qform_code > 0 ? " and qform" : "", in_words(sizes)));
    return;
  }
  if (image.qform_code <= 0) return;
  const Vec3 apart(image.sto_xyz.m[0][3] - image.qto_xyz.m[0][3],
                   image.sto_xyz.m[1][3] - image.qto_xyz.m[1][3],
                   image.sto_xyz.m[2][3] - image.qto_xyz.m[2][3]);
  if ((s - q).norm() > 0.02 * q.norm())
    warnings.push_back("sform and qform turn the axes of the voxels differently: sform was taken");
  else if (apart.norm() > 0.5 * sizes.minCoeff())
    warnings.push_back(
        fmt::format("sform and qform place the first voxel {:.3g} voxels apart: sform was taken",
                    apart.norm() / sizes.minCoeff()));
}

void place(const nifti_image& image, const Vec3& sizes, ImageHeader& header, const std::string& file) {
  header.axes = sizes.asDiagonal();
  header.directions = "right, anterior, superior";
  const bool by_matrix = image.sform_code > 0;
  if (!by_matrix) {
    for (int d = 0; d < 3; ++d)
      if (!(sizes[d] > 0))
        fail(file, fmt::format("pixdim[{}] is {:g}, expected the size of a voxel", d + 1, sizes[d]));
    if (image.qform_code <= 0) {
      header.directions = "along the voxels, since the file names no others";
      return;
    }
  }
  const nifti_dmat44& m = by_matrix ? image.sto_xyz : image.qto_xyz;
  header.axes = axes_of(m);
  header.origin = Vec3(m.m[0][3], m.m[1][3], m.m[2][3]);
  if (by_matrix) compare_forms(image, sizes, header.warnings);
}

ImageHeader header_of(const nifti_image& image, const Vec3& sizes, bool swap, const std::string& file,
                      std::vector<std::string> warnings) {
  ImageHeader header;
  header.warnings = std::move(warnings);
  if (image.nt > 1 || image.nu > 1 || image.nv > 1 || image.nw > 1)
    fail(file, "holds more than one volume, expected three dimensions");
  header.size = {image.nx, image.ny, image.nz};
  place(image, sizes, header, file);
  header.type = *scalar_of(image.datatype);  // known, by check()
  header.swap = swap;
  switch (image.xyz_units) {
    case NIFTI_UNITS_METER:
      name_unit(header, "m");
      break;
    case NIFTI_UNITS_MICRON:
      name_unit(header, "um");
      break;
    case NIFTI_UNITS_MM:
      name_unit(header, "mm");
      break;
    case NIFTI_UNITS_UNKNOWN:
      break;
    default:  // not defined
      name_unit(header, fmt::format("code {}", image.xyz_units));
  }
  if (image.scl_slope != 0 && std::isfinite(image.scl_slope) && std::isfinite(image.scl_inter))
    header.slope = image.scl_slope, header.intercept = image.scl_inter;
  return header;
}

}  // namespace

LabelVolume read_nifti(std::string_view content, const std::string& file) {
  const bool compressed = is_compressed(content);
  const std::string start = compressed ? inflate(content, 540, file) : std::string(content.substr(0, 540));
  std::int32_t size = 0;
  if (start.size() < 4) fail(file, "is shorter than its header, the file is cut short");
  std::memcpy(&size, start.data(), 4);
  const bool swap = size != 348 && size != 540;
  if (swap) size = byte_swapped(size);
  if (size != 348 && size != 540) fail(file, "is no NIfTI file, expected a header of 348 or 540 bytes");
  std::vector<std::string> warnings;
  const Read read = size == 348
                        ? image_of<nifti_1_header>(start, swap, file, warnings, nifti_convert_n1hdr2nim)
                        : image_of<nifti_2_header>(start, swap, file, warnings, nifti_convert_n2hdr2nim);
  const Image& image = read.image;
  const ImageHeader header = header_of(*image, read.sizes, swap, file, std::move(warnings));
  const auto offset = static_cast<std::size_t>(std::max<std::int64_t>(image->iname_offset, size));
  if (!compressed) {
    if (offset > content.size()) fail(file, "the data begin behind the end, the file is cut short");
    return labels_in(header, content.substr(offset), false, file);
  }
  const std::size_t bytes =
      offset + bytes_of(header.type) * checked_voxels(header, file, bytes_of(header.type));
  if (bytes / 1032 > content.size()) fail(file, "announces more voxels than its data can hold");
  const std::string plain = inflate(content, bytes, file);
  return labels_in(header, std::string_view(plain).substr(std::min(offset, plain.size())), false, file);
}

}  // namespace forefeel
