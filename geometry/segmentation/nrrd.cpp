// NRRD (Teem): "NRRD000V", lines "field: value", an empty line, then the data; or "data file: NAME".

#include <fmt/format.h>

#include <bit>
#include <charconv>

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
    const std::string encoding = lower_case(get("encoding"));
    const bool plain = encoding == "raw", packed = encoding == "gzip" || encoding == "gz";
    for (std::int64_t lines = skipped("line skip", "lineskip"); lines > 0; --lines)
      data.remove_prefix(std::min(data.find('\n'), data.size() - 1) + 1);
    const std::int64_t skip = skipped("byte skip", "byteskip");
    if (skip < -1 || skip > static_cast<std::int64_t>(data.size()) || (skip != 0 && packed))
      fields_.fail(fmt::format("byte skip {} lies outside the data, or in packed data, expected less", skip));
    if (skip >= 0) data.remove_prefix(static_cast<std::size_t>(skip));
    if (encoding == "ascii" || encoding == "text" || encoding == "txt")
      return labels_in_text(header, data, fields_.file);
    if (encoding == "hex") return labels_in(header, from_hex(data), false, fields_.file);
    if (!plain && !packed)
      fields_.fail(fmt::format("encoding '{:.40}' is not read, expected raw, gzip, hex or ascii", encoding));
    if (const std::size_t bytes = bytes_of(header.type) * checked_voxels(header, fields_.file, 0);
        skip == -1 && bytes < data.size())
      data.remove_prefix(data.size() - bytes);  // the data are at the end
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

  std::int64_t skipped(const std::string& key, const std::string& other) const {
    const std::string text = fields_.has(key) ? get(key) : get(other);
    std::int64_t skip = 0;
    if (!text.empty() && !parse_integer(text, skip))
      fields_.fail(fmt::format("{} '{:.40}' is no whole number", key, text));
    return skip;
  }

  std::string from_hex(std::string_view text) const {
    std::string bytes;
    std::string digits;
    for (const char c : text) {
      if (trimmed(std::string_view(&c, 1)).empty()) continue;
      digits += c;
      if (digits.size() < 2) continue;
      unsigned byte = 0;
      if (std::from_chars(digits.data(), digits.data() + 2, byte, 16).ptr != digits.data() + 2)
        fields_.fail(fmt::format("'{}' is no hexadecimal number", digits));
      bytes += static_cast<char>(byte);
      digits.clear();
    }
    return bytes;
  }

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
      fields_.fail(fmt::format("dimension '{:.20}', expected 3: one label in each voxel", get("dimension")));
    header.size = fields_.voxels("sizes");
    place(header);
    take_unit(header);
    header.type = type();
    header.swap = (lower_case(get("endian")) == "big") != (std::endian::native == std::endian::big);
    return header;
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
