// MetaImage: lines "Key = value" up to ElementDataFile, then the data, or the name of the file that has them.

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <map>
#include <optional>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/segmentation/raw_image.hpp"

namespace forefeel {
namespace {

class MetaReader {
 public:
  MetaReader(std::string_view content, const std::filesystem::path& path)
      : content_(content), path_(path), file_(path.string()) {
    read_lines();
  }

  LabelVolume read() {
    const ImageHeader header = read_header();
    const bool compressed = flag("CompressedData");
    const std::string source = get("ElementDataFile");
    const bool local = lower_case(source) == "local";
    const std::string other = local ? std::string() : read_beside(path_, source);
    std::string_view data = local ? content_.substr(data_) : std::string_view(other);
    const double skip = numbers("HeaderSize", {0})[0];
    if (skip == -1 && !compressed) {  // the data are at the end
      const std::size_t bytes = bytes_of(header.type) * checked_voxels(header, file_, 0);
      if (bytes < data.size()) data.remove_prefix(data.size() - bytes);
    } else if (skip < 0 || skip > static_cast<double>(data.size())) {
      fail(fmt::format("HeaderSize = {:g} lies outside the data", skip));
    } else {
      data.remove_prefix(static_cast<std::size_t>(skip));
    }
    return labels_in(header, data, compressed, file_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw InputError({.file = file_}, problem); }

  void read_lines() {
    std::size_t at = 0;
    constexpr std::size_t longest_header = 100'000;
    while (at < std::min(content_.size(), longest_header)) {
      const std::size_t end = std::min(content_.find('\n', at), content_.size());
      const std::string_view line = content_.substr(at, end - at);
      at = std::min(end + 1, content_.size());
      const std::size_t equals = line.find('=');
      if (trimmed(line).empty()) continue;
      if (equals == std::string_view::npos)
        fail("is no MetaImage file, expected lines 'Key = value' up to ElementDataFile");
      const std::string key(trimmed(line.substr(0, equals)));
      values_[key] = std::string(trimmed(line.substr(equals + 1)));
      if (key == "ElementDataFile") {
        data_ = at;
        return;
      }
    }
    fail("the header has no ElementDataFile, expected a MetaImage file");
  }

  std::string get(const std::string& key) const {
    const auto found = values_.find(key);
    return found == values_.end() ? std::string() : found->second;
  }
  bool flag(const std::string& key) const { return lower_case(get(key)) == "true"; }

  // The numbers of a key, as many as in `otherwise`, which is returned if the key is missing.
  std::vector<double> numbers(const std::string& key, std::vector<double> otherwise) const {
    const auto found = values_.find(key);
    if (found == values_.end()) return otherwise;
    return header_numbers(found->second, otherwise.size(), file_, key);
  }
  std::vector<double> first_of(std::initializer_list<const char*> keys,
                               const std::vector<double>& otherwise) const {
    for (const char* key : keys)
      if (values_.contains(key)) return numbers(key, otherwise);
    return otherwise;
  }

  Scalar type() const {
    static const std::map<std::string, Scalar> types{
        {"MET_CHAR", Scalar::int8},         {"MET_UCHAR", Scalar::uint8},   {"MET_SHORT", Scalar::int16},
        {"MET_USHORT", Scalar::uint16},     {"MET_INT", Scalar::int32},     {"MET_UINT", Scalar::uint32},
        {"MET_LONG", Scalar::int64},        {"MET_ULONG", Scalar::uint64},  {"MET_LONG_LONG", Scalar::int64},
        {"MET_ULONG_LONG", Scalar::uint64}, {"MET_FLOAT", Scalar::float32}, {"MET_DOUBLE", Scalar::float64}};
    const auto found = types.find(get("ElementType"));
    if (found == types.end())
      fail(fmt::format("ElementType = {:.40} is not read, expected MET_UCHAR, MET_SHORT and the like",
                       get("ElementType")));
    return found->second;
  }

  ImageHeader read_header() const {
    if (numbers("NDims", {3})[0] != 3) fail(fmt::format("NDims = {:.20}, expected 3", get("NDims")));
    if (numbers("ElementNumberOfChannels", {1})[0] != 1)
      fail("has several values in a voxel, expected one label");
    if (values_.contains("BinaryData") && !flag("BinaryData"))
      fail("its data are text, expected BinaryData = True");
    ImageHeader header;
    const std::vector<double> size = numbers("DimSize", {0, 0, 0});
    const std::vector<double> spacing = first_of({"ElementSpacing", "ElementSize"}, {1, 1, 1});
    const std::vector<double> origin = first_of({"Offset", "Position", "Origin"}, {0, 0, 0});
    const std::vector<double> turn =
        first_of({"TransformMatrix", "Rotation", "Orientation"}, {1, 0, 0, 0, 1, 0, 0, 0, 1});
    for (std::size_t d = 0; d < 3; ++d) {
      if (!(std::abs(size[d]) < 1e15) || size[d] != std::floor(size[d]))
        fail(fmt::format("DimSize {:g} is no number of voxels", size[d]));
      header.size[d] = static_cast<std::int64_t>(size[d]);
      const auto column = static_cast<Eigen::Index>(d);
      header.origin[column] = origin[d];
      header.axes.col(column) = spacing[d] * Vec3(turn[3 * d], turn[3 * d + 1], turn[3 * d + 2]);
    }
    header.type = type();
    const bool big = flag("BinaryDataByteOrderMSB") || flag("ElementByteOrderMSB");
    header.swap = big != (std::endian::native == std::endian::big);
    return header;
  }

  std::string_view content_;
  std::filesystem::path path_;
  std::string file_;
  std::map<std::string, std::string> values_;
  std::size_t data_ = 0;
};

}  // namespace

LabelVolume read_meta_image(std::string_view content, const std::filesystem::path& file) {
  return MetaReader(content, file).read();
}

}  // namespace forefeel
