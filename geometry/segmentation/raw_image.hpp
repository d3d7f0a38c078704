#pragma once
// An image as its header describes it, and the conversion of its values to labels. Private to this room.

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/common/scalar_type.hpp"
#include "geometry/segmentation/label_volume.hpp"

namespace forefeel {

struct ImageHeader {
  std::array<std::int64_t, 3> size{};
  Mat3 axes = Mat3::Zero();  // in the file's unit
  Vec3 origin = Vec3::Zero();
  double unit = 1e-3;  // of the file [m]
  std::string unit_name = "mm";
  bool unit_given = false;
  std::string unit_unknown = {};
  Scalar type = Scalar::uint8;
  bool swap = false;                // the byte order is not that of this machine
  double slope = 1, intercept = 0;  // value = slope * stored + intercept
  std::string directions = {};      // of x, y and z
  std::vector<std::string> warnings = {};
};

// Takes the file's word for its unit of length.
void name_unit(ImageHeader& header, std::string_view word);

// |size|. A warning names the entry of the header that is negative.
double positive_size(double size, const std::string& entry, std::vector<std::string>& warnings);

// Number of voxels. InputError for a size that is not positive or overflows, or if the voxels (`bytes_each` in the
// file, and the labels made of them) do not fit into the available memory.
std::size_t checked_voxels(const ImageHeader& header, const std::string& file, std::size_t bytes_each);

// Collects the values of the voxels, one at a time. InputError for more than 65535 different values, or for a value
// that is not a whole number.
class LabelCollector {
 public:
  LabelCollector(const ImageHeader& header, std::size_t voxels, const std::string& file);
  void put(std::size_t at, double value);
  LabelVolume take();  // with values ascending

 private:
  std::uint16_t position_of(std::int64_t value);
  const ImageHeader& header_;
  const std::string& file_;
  LabelVolume volume_;
  std::vector<std::int64_t> found_;
  std::unordered_map<std::int64_t, std::uint16_t> position_;  // in found_
  std::int64_t last_ = 0;
  std::uint16_t last_position_ = 0;
};

// data: exactly the voxels, i fastest.
LabelVolume labels_of(const ImageHeader& header, std::string_view data, const std::string& file);

// The voxels of a file whose data begin at `content`, plain or compressed; InputError if the data are cut short.
LabelVolume labels_in(const ImageHeader& header, std::string_view content, bool compressed,
                      const std::string& file);

// The same of numbers in text, one a voxel.
LabelVolume labels_in_text(const ImageHeader& header, std::string_view text, const std::string& file);

// Decompresses the data of images: gzip or zlib streams.
bool is_compressed(std::string_view data);  // begins with the two bytes that mark gzip
// Returns the first `bytes` of the content, or fewer if the stream is shorter. InputError, with the name of the file,
// if the stream is damaged or if this build has no zlib. Memory grows with the decompressed content, not with `bytes`.
std::string inflate(std::string_view data, std::size_t bytes, const std::string& file);

LabelVolume read_nifti(std::string_view content, const std::string& file);
LabelVolume read_meta_image(std::string_view content, const std::filesystem::path& file);
LabelVolume read_nrrd(std::string_view content, const std::filesystem::path& file);
LabelVolume read_vti(std::string content, const std::string& file);

// The lines "key = value" or "key: value" of a header.
struct HeaderFields {
  std::string file;
  std::map<std::string, std::string> values = {};

  std::string get(const std::string& key) const;  // empty where there is none
  bool has(const std::string& key) const { return values.contains(key); }
  // Exactly `expected` numbers, beside which brackets and commas may stand; InputError for any other count.
  std::vector<double> numbers(const std::string& key, std::size_t expected) const;
  std::array<std::int64_t, 3> voxels(const std::string& key) const;  // three whole numbers
  // The type that lists this word among its names, separated by commas; InputError for an unknown word.
  using TypeNames = std::vector<std::pair<Scalar, std::string_view>>;
  Scalar type(const std::string& key, const std::string& word, const TypeNames& names) const;
  [[noreturn]] void fail(const std::string& problem) const { throw InputError({.file = file}, problem); }
};

// Reads the data file that a header names; it must lie in the header's folder. InputError for a name with a folder.
std::string read_beside(const std::filesystem::path& header, const std::string& name);

}  // namespace forefeel
