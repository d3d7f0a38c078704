// MetaImage: lines "Key = value" up to ElementDataFile, then the data, or the name of the file that has them.

#include <fmt/format.h>

#include <bit>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/segmentation/raw_image.hpp"

namespace forefeel {
namespace {

class MetaReader {
 public:
  MetaReader(std::string_view content, const std::filesystem::path& path)
      : content_(content), path_(path), fields_{.file = path.string()} {
    read_lines();
  }

  LabelVolume read() {
    const ImageHeader header = read_header();
    const bool compressed = flag("CompressedData");
    const std::string source = fields_.get("ElementDataFile");
    const bool local = lower_case(source) == "local";
    const std::string other = local ? std::string() : read_beside(path_, source);
    std::string_view data = local ? content_.substr(data_) : std::string_view(other);
    const double skip = first_of({"HeaderSize"}, {0})[0];
    if (skip == -1 && !compressed) {  // the data are at the end
      const std::size_t bytes = bytes_of(header.type) * checked_voxels(header, fields_.file, 0);
      if (bytes < data.size()) data.remove_prefix(data.size() - bytes);
    } else if (skip < 0 || skip > static_cast<double>(data.size())) {
      fields_.fail(fmt::format("HeaderSize = {:g} lies outside the data", skip));
    } else {
      data.remove_prefix(static_cast<std::size_t>(skip));
    }
    if (fields_.has("BinaryData") && !flag("BinaryData")) return labels_in_text(header, data, fields_.file);
    return labels_in(header, data, compressed, fields_.file);
  }

 private:
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
        fields_.fail("is no MetaImage file, expected lines 'Key = value' up to ElementDataFile");
      const std::string key(trimmed(line.substr(0, equals)));
      fields_.values[key] = std::string(trimmed(line.substr(equals + 1)));
      if (key == "ElementDataFile") {
        data_ = at;
        return;
      }
    }
    fields_.fail("the header has no ElementDataFile, expected a MetaImage file");
  }

  bool flag(const std::string& key) const { return lower_case(fields_.get(key)) == "true"; }

  // The numbers of the first of these keys that is there, as many as in `otherwise`.
  std::vector<double> first_of(std::initializer_list<const char*> keys,
                               const std::vector<double>& otherwise) const {
    for (const char* key : keys)
      if (fields_.has(key)) return fields_.numbers(key, otherwise.size());
    return otherwise;
  }

  Scalar type() const {
    return fields_.type("ElementType", fields_.get("ElementType"),
                        {{Scalar::int8, "MET_CHAR"},
                         {Scalar::uint8, "MET_UCHAR"},
                         {Scalar::int16, "MET_SHORT"},
                         {Scalar::uint16, "MET_USHORT"},
                         {Scalar::int32, "MET_INT"},
                         {Scalar::uint32, "MET_UINT"},
                         {Scalar::int64, "MET_LONG,MET_LONG_LONG"},
                         {Scalar::uint64, "MET_ULONG,MET_ULONG_LONG"},
                         {Scalar::float32, "MET_FLOAT"},
                         {Scalar::float64, "MET_DOUBLE"}});
  }

  ImageHeader read_header() const {
    if (first_of({"NDims"}, {3})[0] != 3)
      fields_.fail(fmt::format("NDims = {:.20}, expected 3", fields_.get("NDims")));
    if (first_of({"ElementNumberOfChannels"}, {1})[0] != 1)
      fields_.fail("has several values in a voxel, expected one label");
    ImageHeader header;
    if (fields_.has("DimSize")) header.size = fields_.voxels("DimSize");
    const std::vector<double> spacing = first_of({"ElementSpacing", "ElementSize"}, {1, 1, 1});
    const std::vector<double> origin = first_of({"Offset", "Position", "Origin"}, {0, 0, 0});
    const std::vector<double> turn =
        first_of({"TransformMatrix", "Rotation", "Orientation"}, {1, 0, 0, 0, 1, 0, 0, 0, 1});
    for (std::size_t d = 0; d < 3; ++d) {
      const auto column = static_cast<Eigen::Index>(d);
      header.origin[column] = origin[d];
      header.axes.col(column) =
          positive_size(spacing[d], fmt::format("ElementSpacing {} of 3", d + 1), header.warnings) *
          Vec3(turn[3 * d], turn[3 * d + 1], turn[3 * d + 2]);
    }
    if (const std::string unit = fields_.get("DistanceUnits"); !unit.empty() && unit != "?")
      name_unit(header, unit);
    header.directions = "left, posterior, superior (DICOM), as is usual in this format";
    header.type = type();
    const bool big = flag("BinaryDataByteOrderMSB") || flag("ElementByteOrderMSB");
    header.swap = big != (std::endian::native == std::endian::big);
    return header;
  }

  std::string_view content_;
  std::filesystem::path path_;
  HeaderFields fields_;
  std::size_t data_ = 0;
};

}  // namespace

LabelVolume read_meta_image(std::string_view content, const std::filesystem::path& file) {
  return MetaReader(content, file).read();
}

}  // namespace forefeel
