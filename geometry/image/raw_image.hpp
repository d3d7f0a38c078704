#pragma once
// An image as a header describes it, before its values are labels. Private to this room.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/image/label_volume.hpp"

namespace forefeel {

enum class Scalar : std::uint8_t {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64
};
std::size_t bytes_of(Scalar type);

struct ImageHeader {
  std::array<std::int64_t, 3> size{};
  Mat3 axes = Mat3::Zero();  // in the file's unit
  Vec3 origin = Vec3::Zero();
  double unit = 1e-3;  // of the file [m]
  std::string unit_name = "mm";
  bool unit_given = false;
  Scalar type = Scalar::uint8;
  bool swap = false;                // bytes are in the order of other machines
  double slope = 1, intercept = 0;  // value = slope * stored + intercept
};

// Number of voxels. InputError for a size that is not positive, that overflows, or whose voxels (`bytes_each`, and
// what they become) do not fit into the memory that is left.
std::size_t checked_voxels(const ImageHeader& header, const std::string& file, std::size_t bytes_each);

// Values appear one after the other; more than 255 different ones, or one that is not whole, is an InputError.
class LabelCollector {
 public:
  LabelCollector(const ImageHeader& header, std::size_t voxels, const std::string& file);
  void put(std::size_t at, double value);
  LabelVolume take();  // with values ascending

 private:
  std::uint8_t position_of(std::int64_t value);
  const ImageHeader& header_;
  const std::string& file_;
  LabelVolume volume_;
  std::vector<std::int64_t> found_;
  std::int64_t last_ = 0;
  std::uint8_t last_position_ = 0;
};

// data: exactly the voxels, i fastest.
LabelVolume labels_of(const ImageHeader& header, std::string_view data, const std::string& file);

// The voxels of a file whose data follow at `content`, plain or compressed; InputError where they are cut short.
LabelVolume labels_in(const ImageHeader& header, std::string_view content, bool compressed,
                      const std::string& file);

LabelVolume read_nifti(std::string_view content, const std::string& file);
LabelVolume read_meta_image(std::string_view content, const std::filesystem::path& file);
LabelVolume read_nrrd(std::string_view content, const std::filesystem::path& file);
LabelVolume read_vti(std::string content, const std::string& file);

// The numbers in a header's text, as many as expected; else InputError.
std::vector<double> header_numbers(const std::string& text, std::size_t expected, const std::string& file,
                                   const std::string& key);

// The file with the data that a header names, in its own folder. InputError for a name with a folder.
std::string read_beside(const std::filesystem::path& header, const std::string& name);

}  // namespace forefeel
