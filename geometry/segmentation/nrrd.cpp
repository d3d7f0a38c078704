// NRRD (Teem): "NRRD000V", lines "field: value", an empty line, then the data; or "data file: NAME".

#include <fmt/format.h>

#include <bit>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/mesh/length_unit.hpp"
#include "geometry/segmentation/raw_image.hpp"

namespace forefeel {
namespace {

class NrrdReader {
 public:
  NrrdReader(std::string_view content, const std::filesystem::path& path)
      : content_(content), path_(path), fields_{.file = path.string()} {
    read_lines();
  }

  LabelVolume read() {
    const ImageHeader header = read_header();
    const std::string source = get("data file").empty() ? get("datafile") : get("data file");
    const std::string other = source.empty() ? std::string() : read_beside(path_, source);
    std::string_view data = source.empty() ? content_.substr(data_) : std::string_view(other);
    for (const char* skip : {"line skip", "lineskip", "byte skip", "byteskip"})
      if (!get(skip).empty() && get(skip) != "0")
        fields_.fail(fmt::format("{} is not read, expected data without it", skip));
    const std::string encoding = lower_case(get("encoding"));
    if (encoding == "ascii" || encoding == "text" || encoding == "txt") return from_text(header, data);
    if (encoding != "raw" && encoding != "gzip" && encoding != "gz")
      fields_.fail(fmt::format("encoding '{:.40}' is not read, expected raw, gzip or ascii", encoding));
    return labels_in(header, data, encoding != "raw", fields_.file);
  }

 private:
  void read_lines() {
    if (!content_.starts_with("NRRD000"))
      fields_.fail("is no NRRD file, expected NRRD000… in the first line");
    constexpr std::size_t longest_header = 1'000'000;
    std::size_t at = std::min(content_.find('\n'), content_.size());
    while (at < std::min(content_.size(), longest_header)) {
      ++at;
      const std::size_t end = std::min(content_.find('\n', at), content_.size());
      const std::string_view line =
          trimmed(content_.substr(std::min(at, content_.size()), end - std::min(at, end)));
      at = end;
      if (line.empty()) break;
      const std::size_t colon = line.find(':');
      if (line.front() == '#' || colon == std::string_view::npos || line.substr(colon).starts_with(":="))
        continue;
      fields_.values[lower_case(line.substr(0, colon))] = std::string(trimmed(line.substr(colon + 1)));
    }
    data_ = std::min(at + 1, content_.size());
  }

  std::string get(const std::string& key) const { return fields_.get(key); }

  Scalar type() const {
    return fields_.type("type", lower_case(get("type")),
                        {{Scalar::int8, "signed char,int8,int8_t"},
                         {Scalar::uint8, "uchar,unsigned char,uint8,uint8_t"},
                         {Scalar::int16, "short,short int,int16,int16_t"},
                         {Scalar::uint16, "ushort,unsigned short,uint16,uint16_t"},
                         {Scalar::int32, "int,signed int,int32,int32_t"},
                         {Scalar::uint32, "uint,unsigned int,uint32,uint32_t"},
                         {Scalar::int64, "longlong,long long,int64,int64_t"},
                         {Scalar::uint64, "ulonglong,unsigned long long,uint64,uint64_t"},
                         {Scalar::float32, "float"},
                         {Scalar::float64, "double"}});
  }

  // "left-posterior-superior", "LPS" or "3D-right-handed", as the file has it.
  static std::string directions(const std::string& space) {
    if (space == "lps" || space == "left-posterior-superior") return "left, posterior, superior";
    if (space == "ras" || space == "right-anterior-superior") return "right, anterior, superior";
    if (space == "las" || space == "left-anterior-superior") return "left, anterior, superior";
    return space.empty() ? "not named by the file" : space;
  }

  void place(ImageHeader& header) const {
    header.axes.setIdentity();
    if (fields_.has("space directions")) {
      const std::vector<double> m = fields_.numbers("space directions", 9);
      for (int d = 0; d < 3; ++d)
        for (int r = 0; r < 3; ++r) header.axes(r, d) = m[static_cast<std::size_t>(3 * d + r)];
    } else if (fields_.has("spacings")) {
      const std::vector<double> s = fields_.numbers("spacings", 3);
      for (std::size_t d = 0; d < 3; ++d)
        header.axes.col(static_cast<Eigen::Index>(d)) =
            positive_size(s[d], fmt::format("spacings, entry {} of 3,", d + 1), header.warnings) *
            Vec3::Unit(static_cast<Eigen::Index>(d));
    }
    header.directions = directions(lower_case(get("space")));
    if (fields_.has("space origin")) {
      const std::vector<double> o = fields_.numbers("space origin", 3);
      header.origin = Vec3(o[0], o[1], o[2]);
    }
  }

  // "mm" "mm" "mm", one of each axis of space (or, of spacings, of the volume).
  void take_unit(ImageHeader& header) const {
    std::vector<std::string> words;
    const std::string units = get(fields_.has("space units") ? "space units" : "units");
    for (std::size_t at = units.find('"'); at != std::string::npos; at = units.find('"', at)) {
      const std::size_t end = std::min(units.find('"', at + 1), units.size());
      words.emplace_back(trimmed(std::string_view(units).substr(at + 1, end - at - 1)));
      at = std::min(end + 1, units.size());
    }
    if (words.empty() && !units.empty()) words = {units};
    std::erase_if(words, [](const std::string& word) { return word.empty() || word == "???"; });
    if (words.empty()) return;
    for (const std::string& word : words)
      if (word != words[0] && unit_of(word) != unit_of(words[0]))
        fields_.fail(
            fmt::format("the units '{:.20}' and '{:.20}' differ, expected one for all axes", words[0], word));
    name_unit(header, words[0]);
  }

  ImageHeader read_header() const {
    ImageHeader header;
    if (get("dimension") != "3")
      fields_.fail(fmt::format("dimension '{:.20}', expected 3", get("dimension")));
    header.size = fields_.voxels("sizes");
    place(header);
    take_unit(header);
    header.type = type();
    header.swap = (lower_case(get("endian")) == "big") != (std::endian::native == std::endian::big);
    return header;
  }

  LabelVolume from_text(const ImageHeader& header, std::string_view data) const {
    const std::size_t voxels = checked_voxels(header, fields_.file, 0);
    if (voxels > data.size()) fields_.fail("the text holds fewer numbers than voxels, the file is cut short");
    Scanner in(std::string(data), fields_.file);
    LabelCollector to(header, voxels, fields_.file);
    for (std::size_t v = 0; v < voxels; ++v) to.put(v, in.real("the label of a voxel"));
    return to.take();
  }

  std::string_view content_;
  std::filesystem::path path_;
  HeaderFields fields_;
  std::size_t data_ = 0;
};

}  // namespace

LabelVolume read_nrrd(std::string_view content, const std::filesystem::path& file) {
  return NrrdReader(content, file).read();
}

}  // namespace forefeel
