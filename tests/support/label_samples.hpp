#pragma once
// One small label volume in every format, written by code that shares nothing with the readers.

#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>

#include "geometry/segmentation/label_volume.hpp"

namespace forefeel::test {

// Concentric spheres about the middle of the volume: label 7 within `inner`, 1 within `outer`; lengths in mm.
inline LabelVolume nested_spheres(std::array<std::int64_t, 3> size, const Vec3& spacing, double outer,
                                  double inner) {
  LabelVolume volume;
  volume.size = size;
  volume.axes = 1e-3 * spacing.asDiagonal().toDenseMatrix();
  volume.values = {0, 1, 7};
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j)
      for (std::int64_t i = 0; i < size[0]; ++i) {
        Vec3 x(static_cast<double>(2 * i - size[0] + 1), static_cast<double>(2 * j - size[1] + 1),
               static_cast<double>(2 * k - size[2] + 1));
        const double r = 0.5 * x.cwiseProduct(spacing).norm();
        volume.voxels.push_back(r < inner ? 2 : r < outer ? 1 : 0);
      }
  return volume;
}

inline std::string label_bytes(const LabelVolume& v) {
  std::string bytes;
  for (const std::uint16_t at : v.voxels) bytes += static_cast<char>(v.values[at]);
  return bytes;
}

inline std::string label_text(const LabelVolume& v) {
  std::string text;
  for (const std::uint16_t at : v.voxels) text += std::to_string(v.values[at]) + ' ';
  return text;
}

// 348 bytes by their places in the standard, then 4 of "no extension". Spacing 1, 2, 3 mm, centre of the first voxel
// at (10, 20, 30) mm.
inline std::string nifti_bytes(const LabelVolume& v) {
  std::string bytes(352, '\0');
  const auto put = [&](std::size_t at, auto value) { std::memcpy(bytes.data() + at, &value, sizeof value); };
  put(0, std::int32_t{348});
  put(40, std::int16_t{3});
  for (std::size_t d = 0; d < 3; ++d) put(42 + 2 * d, static_cast<std::int16_t>(v.size[d]));
  put(70, std::int16_t{2}), put(72, std::int16_t{8});  // unsigned bytes
  for (std::size_t d = 0; d < 3; ++d) put(80 + 4 * d, static_cast<float>(d + 1));
  put(76, 1.0f), put(108, 352.0f), put(112, 1.0f);
  bytes[123] = 2;             // mm
  put(254, std::int16_t{1});  // sform
  for (std::size_t d = 0; d < 3; ++d)
    put(280 + 20 * d, static_cast<float>(d + 1)), put(292 + 16 * d, 10.0f * static_cast<float>(d + 1));
  bytes.replace(344, 3, "n+1");
  return bytes + label_bytes(v);
}

inline std::string size_words(const LabelVolume& v) {
  return std::to_string(v.size[0]) + ' ' + std::to_string(v.size[1]) + ' ' + std::to_string(v.size[2]);
}

// All with spacing 1, 2, 3 mm and the first voxel at (10, 20, 30) mm.
inline std::map<std::string, std::string> label_files(const LabelVolume& v) {
  const std::string n = size_words(v);
  const std::string extent = "0 " + std::to_string(v.size[0] - 1) + " 0 " + std::to_string(v.size[1] - 1) +
                             " 0 " + std::to_string(v.size[2] - 1);
  const std::string nrrd = "NRRD0004\n# labels\ntype: uchar\ndimension: 3\nspace dimension: 3\nsizes: " + n +
                           "\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (10,20,30)\n";
  return {
      {"a.nii", nifti_bytes(v)},
      {"b.mha",
       "ObjectType = Image\nNDims = 3\nBinaryData = True\nOffset = 10 20 30\nElementSpacing = 1 2 3\nDimSize "
       "= " +
           n + "\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + label_bytes(v)},
      {"c.nrrd", nrrd + "encoding: raw\n\n" + label_bytes(v)},
      {"d.nrrd", nrrd + "encoding: ascii\n\n" + label_text(v)},
      {"e.vti",
       "<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"" +
           extent + "\" Origin=\"10 20 30\" Spacing=\"1 2 3\"><Piece Extent=\"" + extent +
           "\"><PointData><DataArray type=\"UInt8\" Name=\"labels\" format=\"ascii\">" + label_text(v) +
           "</DataArray></PointData></Piece></ImageData></VTKFile>\n"}};
}

}  // namespace forefeel::test
