// NRRD (Teem): "NRRD000V", lines "field: value", an empty line, then the data; or "data file: NAME".

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <map>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/segmentation/raw_image.hpp"

namespace forefeel {
namespace {

class NrrdReader {
 public:
  NrrdReader(std::string_view content, const std::filesystem::path& path)
      : content_(content), path_(path), file_(path.string()) {
    read_lines();
  }

  LabelVolume read() {
    const ImageHeader header = read_header();
    const std::string source = get("data file").empty() ? get("datafile") : get("data file");
    const std::string other = source.empty() ? std::string() : read_beside(path_, source);
    std::string_view data = source.empty() ? content_.substr(data_) : std::string_view(other);
    for (const char* skip : {"line skip", "lineskip", "byte skip", "byteskip"})
      if (!get(skip).empty() && get(skip) != "0")
        fail(fmt::format("{} is not read, expected data without it", skip));
    const std::string encoding = lower_case(get("encoding"));
    if (encoding == "ascii" || encoding == "text" || encoding == "txt") return from_text(header, data);
    if (encoding != "raw" && encoding != "gzip" && encoding != "gz")
      fail(fmt::format("encoding '{:.40}' is not read, expected raw, gzip or ascii", encoding));
    return labels_in(header, data, encoding != "raw", file_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw InputError({.file = file_}, problem); }

  void read_lines() {
    if (!content_.starts_with("NRRD000")) fail("is no NRRD file, expected NRRD000… in the first line");
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
      values_[lower_case(line.substr(0, colon))] = std::string(trimmed(line.substr(colon + 1)));
    }
    data_ = std::min(at + 1, content_.size());
  }

  std::string get(const std::string& key) const {
    const auto found = values_.find(key);
    return found == values_.end() ? std::string() : found->second;
  }

  std::vector<double> numbers(const std::string& key, std::size_t expected) const {
    std::string text = get(key);
    for (char& letter : text)
      if (letter == '(' || letter == ')' || letter == ',') letter = ' ';
    return header_numbers(text, expected, file_, key);
  }

  Scalar type() const {
    static const std::map<std::string, Scalar> types{{"signed char", Scalar::int8},
                                                     {"int8", Scalar::int8},
                                                     {"int8_t", Scalar::int8},
                                                     {"uchar", Scalar::uint8},
                                                     {"unsigned char", Scalar::uint8},
                                                     {"uint8", Scalar::uint8},
                                                     {"uint8_t", Scalar::uint8},
                                                     {"short", Scalar::int16},
                                                     {"short int", Scalar::int16},
                                                     {"int16", Scalar::int16},
                                                     {"int16_t", Scalar::int16},
                                                     {"ushort", Scalar::uint16},
                                                     {"unsigned short", Scalar::uint16},
                                                     {"uint16", Scalar::uint16},
                                                     {"uint16_t", Scalar::uint16},
                                                     {"int", Scalar::int32},
                                                     {"signed int", Scalar::int32},
                                                     {"int32", Scalar::int32},
                                                     {"int32_t", Scalar::int32},
                                                     {"uint", Scalar::uint32},
                                                     {"unsigned int", Scalar::uint32},
                                                     {"uint32", Scalar::uint32},
                                                     {"uint32_t", Scalar::uint32},
                                                     {"longlong", Scalar::int64},
                                                     {"long long", Scalar::int64},
                                                     {"int64", Scalar::int64},
                                                     {"int64_t", Scalar::int64},
                                                     {"ulonglong", Scalar::uint64},
                                                     {"unsigned long long", Scalar::uint64},
                                                     {"uint64", Scalar::uint64},
                                                     {"uint64_t", Scalar::uint64},
                                                     {"float", Scalar::float32},
                                                     {"double", Scalar::float64}};
    const auto found = types.find(lower_case(get("type")));
    if (found == types.end())
      fail(fmt::format("type '{:.40}' is not read, expected uchar, short and the like", get("type")));
    return found->second;
  }

  void place(ImageHeader& header) const {
    header.axes.setIdentity();
    if (values_.contains("space directions")) {
      const std::vector<double> m = numbers("space directions", 9);
      for (unsigned d = 0; d < 3; ++d)
        for (unsigned r = 0; r < 3; ++r) header.axes(r, d) = m[3 * d + r];
    } else if (values_.contains("spacings")) {
      const std::vector<double> s = numbers("spacings", 3);
      header.axes = Vec3(s[0], s[1], s[2]).asDiagonal();
    }
    if (values_.contains("space origin")) {
      const std::vector<double> o = numbers("space origin", 3);
      header.origin = Vec3(o[0], o[1], o[2]);
    }
  }

  void take_unit(ImageHeader& header) const {
    const std::string units = lower_case(get("space units"));  // "mm" "mm" "mm"
    if (units.empty()) return;
    header.unit_given = true;
    if (units.starts_with("\"mm\"")) return;
    if (units.starts_with("\"m\""))
      header.unit = 1, header.unit_name = "m";
    else if (units.starts_with("\"cm\""))
      header.unit = 1e-2, header.unit_name = "cm";
    else if (units.starts_with("\"um\""))
      header.unit = 1e-6, header.unit_name = "micrometres";
    else
      header.unit_given = false;
  }

  ImageHeader read_header() const {
    ImageHeader header;
    if (get("dimension") != "3") fail(fmt::format("dimension '{:.20}', expected 3", get("dimension")));
    const std::vector<double> size = numbers("sizes", 3);
    for (std::size_t d = 0; d < 3; ++d) {
      if (!(std::abs(size[d]) < 1e15) || size[d] != std::floor(size[d]))
        fail(fmt::format("size {:g} is no number of voxels", size[d]));
      header.size[d] = static_cast<std::int64_t>(size[d]);
    }
    place(header);
    take_unit(header);
    header.type = type();
    header.swap = (lower_case(get("endian")) == "big") != (std::endian::native == std::endian::big);
    return header;
  }

  LabelVolume from_text(const ImageHeader& header, std::string_view data) const {
    const std::size_t voxels = checked_voxels(header, file_, 0);
    if (voxels > data.size()) fail("the text holds fewer numbers than voxels, the file is cut short");
    Scanner in(std::string(data), file_);
    LabelCollector to(header, voxels, file_);
    for (std::size_t v = 0; v < voxels; ++v) to.put(v, in.real("the label of a voxel"));
    return to.take();
  }

  std::string_view content_;
  std::filesystem::path path_;
  std::string file_;
  std::map<std::string, std::string> values_;
  std::size_t data_ = 0;
};

}  // namespace

LabelVolume read_nrrd(std::string_view content, const std::filesystem::path& file) {
  return NrrdReader(content, file).read();
}

}  // namespace forefeel
