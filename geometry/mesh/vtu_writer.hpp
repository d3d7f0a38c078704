#pragma once
// Writes unstructured grids for ParaView (.vtu): one piece of cells of one kind, with arrays as text, as base64 or
// appended raw behind the XML.
//
//   VtuWriter out("points.vtu", VtuData::base64);
//   out.begin(points.size(), points.size());
//   out.section("PointData");
//   out.array<double>("force", points.size(), 3, [&](std::size_t i, int k) { return force[i][k]; });
//   out.points(points);
//   out.vertices(points.size());
//   out.finish();

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "geometry/common/output_file.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

// packed: raw, compressed by vtkZLibDataCompressor if the build has zlib.
enum class VtuData { text, base64, raw, packed };

namespace vtk_cell {
inline constexpr std::uint8_t vertex = 1, line = 3, triangle = 5, tetra = 10,
                              voxel = 11;  // eight corners: x fastest, then y, z
}

class VtuWriter {
 public:
  VtuWriter(const std::filesystem::path& file, VtuData data);  // appears complete, by finish(), or not at all
  VtuWriter(std::string& text, VtuData data);                  // appends to `text`

  // field: XML of the arrays that belong to the whole grid; may be empty.
  void begin(std::size_t points, std::size_t cells, std::string_view field = "");
  // "PointData", "CellData", "Points" or "Cells"; ends the section before.
  void section(std::string_view name, std::string_view attributes = "");
  // T: double, float, std::int64_t, std::int32_t, std::uint8_t; char: texts, each with a zero at its end. NaN may be
  // among the values. Without a name for "".
  template <class T>
  void array(std::string_view name, int width, std::span<const T> values);
  template <class T, class Value>
  void array(std::string_view name, std::size_t items, int width, Value&& value) {
    std::vector<T> all;
    all.reserve(items * static_cast<std::size_t>(width));
    for (std::size_t i = 0; i < items; ++i)
      for (int k = 0; k < width; ++k) all.push_back(static_cast<T>(value(i, k)));
    array<T>(name, width, all);
  }
  // The sections Points and Cells. connectivity: `corners` points for each cell.
  void points(std::span<const Vec3> all, std::string_view name = "position");
  void cells(std::span<const std::int64_t> connectivity, std::size_t corners, std::uint8_t type);
  template <class Cell>
  void cells(const std::vector<Cell>& all, std::uint8_t type) {
    std::vector<std::int64_t> connectivity;
    for (const Cell& cell : all)
      for (const auto point : cell) connectivity.push_back(static_cast<std::int64_t>(point));
    cells(connectivity, std::tuple_size_v<Cell>, type);
  }
  void vertices(std::size_t count);  // the section Cells: one cell for each point
  // For arrays that many files share: the bytes once, with their header, for VtuData::packed.
  static std::string pack(std::span<const char> bytes);
  void packed_array(std::string_view type, std::string_view name, int width, std::string_view packed);
  void finish();

 private:
  void open_array(std::string_view type, std::string_view name, int width, const char* format,
                  std::string_view end);

  void open_grid();
  void out(std::string_view bytes);

  std::optional<OutputFile> file_;
  std::string* text_ = nullptr;  // null: to file_
  VtuData data_;
  std::string section_, appended_;
};

}  // namespace forefeel
