// VTK XML image data: WholeExtent, Origin, Spacing, Direction, and one array of points or cells.

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/mesh/vtk_xml.hpp"
#include "geometry/segmentation/raw_image.hpp"

namespace forefeel {
namespace {

using Extent = std::array<std::int64_t, 6>;

class VtiReader {
 public:
  VtiReader(std::string content, std::string file)
      : file_(std::move(file)),
        bytes_(content.size()),
        reader_(Scanner(std::move(content), file_), "ImageData") {}

  LabelVolume read() {
    std::optional<LabelCollector> to;
    std::size_t filled = 0;
    reader_.read([&](const VtkXmlPiece& piece) {
      const auto [section, name] = array_of(piece);
      if (!to) {
        begin(section == "CellData");
        const std::size_t voxels = checked_voxels(header_, file_, 16);
        if (voxels / 1100 > bytes_) fail("WholeExtent announces more voxels than the file can hold");
        to.emplace(header_, voxels, file_);
      }
      if ((section == "CellData") != cells_)
        fail("has labels at points in one piece and in cells in another");
      filled += fill(piece, reader_.array(piece, section, name), *to);
    });
    if (!to) fail("holds no piece");
    if (filled != static_cast<std::size_t>(header_.size[0] * header_.size[1] * header_.size[2]))
      fail(fmt::format("{} values for {} x {} x {} voxels", filled, header_.size[0], header_.size[1],
                       header_.size[2]));
    return to->take();
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw InputError({.file = file_}, problem); }

  // The one array with one number each, of points or else of cells.
  std::pair<std::string, std::string> array_of(const VtkXmlPiece& piece) const {
    std::vector<std::pair<std::string, std::string>> found;
    for (const char* section : {"PointData", "CellData"}) {
      const auto part = piece.arrays.find(section);
      if (part == piece.arrays.end()) continue;
      for (const auto& [name, array] : part->second)
        if (const std::string n = array.attribute("NumberOfComponents"); n.empty() || n == "1")
          found.emplace_back(section, name);
    }
    if (found.empty()) fail("holds no array with one number for each point or cell, expected labels");
    if (found.size() > 1)
      fail(fmt::format("holds the arrays '{:.40}' and '{:.40}', expected one with labels", found[0].second,
                       found[1].second));
    return found[0];
  }

  std::vector<double> numbers(const char* key, std::vector<double> otherwise) const {
    const auto found = reader_.attributes().find(key);
    if (found == reader_.attributes().end()) return otherwise;
    return HeaderFields{.file = file_, .values = {{key, found->second}}}.numbers(key, otherwise.size());
  }

  Extent extent_of(const std::string& text, const char* what) const {
    Scanner in(text, file_ + ": " + what);
    Extent extent{};
    for (auto& bound : extent) bound = in.integer("a bound of the extent", -0x7fffffff, 0x7fffffff);
    for (std::size_t d = 0; d < 3; ++d)
      if (extent[2 * d + 1] < extent[2 * d]) fail(fmt::format("{} is empty, expected voxels", what));
    return extent;
  }

  void begin(bool cells) {
    cells_ = cells;
    const auto whole = reader_.attributes().find("WholeExtent");
    if (whole == reader_.attributes().end()) fail("<ImageData> has no WholeExtent");
    whole_ = extent_of(whole->second, "WholeExtent");
    const std::vector<double> origin = numbers("Origin", {0, 0, 0}), spacing = numbers("Spacing", {1, 1, 1}),
                              turn = numbers("Direction", {1, 0, 0, 0, 1, 0, 0, 0, 1});
    Vec3 first;
    for (unsigned d = 0; d < 3; ++d) {
      header_.size[d] = whole_[2 * d + 1] - whole_[2 * d] + (cells ? 0 : 1);
      header_.origin[d] = origin[d];
      const double size = positive_size(spacing[d], fmt::format("Spacing {} of 3", d + 1), header_.warnings);
      for (unsigned r = 0; r < 3; ++r) header_.axes(r, d) = size * turn[3 * r + d];
      first[d] = static_cast<double>(whole_[2 * d]) + (cells ? 0.5 : 0.0);
    }
    header_.origin += header_.axes * first;
    header_.directions = "not named by the file";
  }

  std::size_t fill(const VtkXmlPiece& piece, const VtkXmlArray& array, LabelCollector& to) const {
    const auto text = piece.attributes.find("Extent");
    const Extent at =
        extent_of(text == piece.attributes.end() ? std::string() : text->second, "Extent of a piece");
    const std::int64_t more = cells_ ? 0 : 1;
    std::array<std::int64_t, 3> n{};
    for (std::size_t d = 0; d < 3; ++d) {
      if (at[2 * d] < whole_[2 * d] || at[2 * d + 1] > whole_[2 * d + 1])
        fail("a piece lies outside WholeExtent");
      n[d] = at[2 * d + 1] - at[2 * d] + more;
    }
    if (!cells_ && n != header_.size) fail("has several pieces with labels at points, expected one piece");
    std::vector<double> values;
    if (array.attribute("type").starts_with("Float")) {
      values = reader_.reals(array);
    } else {
      for (const std::int64_t value : reader_.integers(array)) values.push_back(static_cast<double>(value));
    }
    if (values.size() != static_cast<std::size_t>(n[0] * n[1] * n[2]))
      fail(fmt::format("an array of {} values for {} x {} x {} voxels", values.size(), n[0], n[1], n[2]));
    std::size_t v = 0;
    for (std::int64_t k = 0; k < n[2]; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j)
        for (std::int64_t i = 0; i < n[0]; ++i, ++v)
          to.put(static_cast<std::size_t>(
                     i + at[0] - whole_[0] +
                     header_.size[0] * (j + at[2] - whole_[2] + header_.size[1] * (k + at[4] - whole_[4]))),
                 values[v]);
    return values.size();
  }

  std::string file_;
  std::size_t bytes_;  // of the file
  VtkXmlReader reader_;
  ImageHeader header_;
  Extent whole_{};
  bool cells_ = false;
};

}  // namespace

LabelVolume read_vti(std::string content, const std::string& file) {
  return VtiReader(std::move(content), file).read();
}

}  // namespace forefeel
