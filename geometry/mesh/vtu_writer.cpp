#include "geometry/mesh/vtu_writer.hpp"

#include <fmt/format.h>
#ifdef FOREFEEL_ZLIB
#include <zlib.h>
#endif

#include <bit>
#include <cmath>
#include <iterator>
#include <new>
#include <numeric>
#include <type_traits>

#include "geometry/common/base64.hpp"
#include "geometry/common/utf8.hpp"

namespace forefeel {
namespace {

constexpr std::string_view native_order =
    std::endian::native == std::endian::big ? "BigEndian" : "LittleEndian";

template <class T>
constexpr std::string_view vtk_type() {
  if (std::is_same_v<T, double>) return "Float64";
  if (std::is_same_v<T, float>) return "Float32";
  if (std::is_same_v<T, std::int64_t>) return "Int64";
  if (std::is_same_v<T, std::int32_t>) return "Int32";
  if (std::is_same_v<T, std::uint8_t>) return "UInt8";
  return "String";
}

template <class T>
std::string as_text(int width, std::span<const T> values) {
  const std::size_t in_line = width > 1 ? static_cast<std::size_t>(width) : 20;
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool last = i % in_line == in_line - 1 || i + 1 == values.size();
    if (std::isnan(static_cast<double>(values[i])))
      text += "NaN";
    else
      fmt::format_to(std::back_inserter(text), "{}", values[i]);
    text += last ? '\n' : ' ';
  }
  return text;
}

std::string words(std::initializer_list<std::uint64_t> values) {
  return {reinterpret_cast<const char*>(std::data(values)), values.size() * sizeof(std::uint64_t)};
}

}  // namespace

VtuWriter::VtuWriter(const std::filesystem::path& file, VtuData data) : file_(file), data_(data) {
  open_grid();
}

VtuWriter::VtuWriter(std::string& text, VtuData data) : text_(&text), data_(data) {
  open_grid();
}

void VtuWriter::out(std::string_view bytes) {
  if (text_)
    text_->append(bytes);
  else
    file_->write(bytes);
}

void VtuWriter::open_grid() {
  std::string more = data_ == VtuData::text ? "" : " header_type=\"UInt64\"";
#ifdef FOREFEEL_ZLIB
  if (data_ == VtuData::packed) more += " compressor=\"vtkZLibDataCompressor\"";
#endif
  out(
      fmt::format("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
                  "byte_order=\"{}\"{}>\n<UnstructuredGrid>\n",
                  native_order, more));
}

void VtuWriter::begin(std::size_t points, std::size_t cells, std::string_view field) {
  if (!field.empty()) out(fmt::format("<FieldData>\n{}</FieldData>\n", field));
  out(fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", points, cells));
}

void VtuWriter::section(std::string_view name, std::string_view attributes) {
  if (!section_.empty()) out(fmt::format("</{}>\n", section_));
  section_ = name;
  if (!name.empty()) out(fmt::format("<{}{}{}>\n", name, attributes.empty() ? "" : " ", attributes));
}

void VtuWriter::open_array(std::string_view type, std::string_view name, int width, const char* format,
                           std::string_view end) {
  out(fmt::format(
      "<DataArray type=\"{}\"{}{} format=\"{}\"{}>\n", type,
      name.empty() ? "" : fmt::format(" Name=\"{}\"", html_escaped(name)),
      width == 1 && data_ == VtuData::text ? "" : fmt::format(" NumberOfComponents=\"{}\"", width), format,
      end));
}

template <class T>
void VtuWriter::array(std::string_view name, int width, std::span<const T> values) {
  const std::span bytes(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  if (data_ == VtuData::packed) return packed_array(vtk_type<T>(), name, width, pack(bytes));
  const std::string size = words({bytes.size()});
  if (data_ == VtuData::raw) {
    packed_array(vtk_type<T>(), name, width, size);
    appended_.append(bytes.data(), bytes.size());
    return;
  }
  open_array(vtk_type<T>(), name, width, data_ == VtuData::text ? "ascii" : "binary", "");
  if (data_ == VtuData::text)
    out(as_text(width, values));
  else
    out(base64(size + std::string(bytes.data(), bytes.size())) + "\n");
  out("</DataArray>\n");
}
template void VtuWriter::array(std::string_view, int, std::span<const double>);
template void VtuWriter::array(std::string_view, int, std::span<const float>);
template void VtuWriter::array(std::string_view, int, std::span<const std::int64_t>);
template void VtuWriter::array(std::string_view, int, std::span<const std::int32_t>);
template void VtuWriter::array(std::string_view, int, std::span<const std::uint8_t>);
template void VtuWriter::array(std::string_view, int, std::span<const char>);

void VtuWriter::points(std::span<const Vec3> all, std::string_view name) {
  section("Points");
  array<double>(name, all.size(), 3, [&](std::size_t i, int k) { return all[i][k]; });
}

void VtuWriter::cells(std::span<const std::int64_t> connectivity, std::size_t corners, std::uint8_t type) {
  const std::size_t count = connectivity.size() / corners;
  section("Cells");
  array<std::int64_t>("connectivity", 1, connectivity);
  array<std::int64_t>("offsets", count, 1, [&](std::size_t i, int) { return (i + 1) * corners; });
  array<std::uint8_t>("types", 1, std::vector<std::uint8_t>(count, type));
}

void VtuWriter::vertices(std::size_t count) {
  std::vector<std::int64_t> all(count);
  std::iota(all.begin(), all.end(), 0);
  cells(all, 1, vtk_cell::vertex);
}

std::string VtuWriter::pack(std::span<const char> bytes) {
#ifdef FOREFEEL_ZLIB
  if (bytes.empty()) return words({0});
  std::string data(compressBound(bytes.size()), '\0');
  uLongf size = data.size();
  if (compress2(reinterpret_cast<Bytef*>(data.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                bytes.size(), 4) != Z_OK)
    throw std::bad_alloc();
  data.resize(size);
  return words({1, bytes.size(), 0, size}) + data;
#else
  return words({bytes.size()}) + std::string(bytes.data(), bytes.size());
#endif
}

void VtuWriter::packed_array(std::string_view type, std::string_view name, int width,
                             std::string_view packed) {
  open_array(type, name, width, "appended", fmt::format(" offset=\"{}\"/", appended_.size()));
  appended_ += packed;
}

void VtuWriter::finish() {
  section("");
  out("</Piece>\n</UnstructuredGrid>\n");
  if (!appended_.empty()) {
    out("<AppendedData encoding=\"raw\">\n_");
    out(appended_);
    out("\n</AppendedData>\n");
  }
  out("</VTKFile>\n");
  if (file_) file_->commit();
}

}  // namespace forefeel
