#include "geometry/mesh/vtu_series.hpp"

#include <fmt/format.h>
#ifdef FOREFEEL_ZLIB
#include <zlib.h>
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <new>

#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/mesh/vtk_xml.hpp"

namespace forefeel {
namespace {

constexpr const char* byte_order = std::endian::native == std::endian::big ? "BigEndian" : "LittleEndian";
#ifdef FOREFEEL_ZLIB
constexpr const char* compressor = " compressor=\"vtkZLibDataCompressor\"";
#else
constexpr const char* compressor = "";
#endif

template <class T>
std::span<const char> bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::string words(std::initializer_list<std::size_t> values) {
  std::string text;
  for (const std::size_t value : values) {
    const auto word = static_cast<std::uint32_t>(value);
    text.append(reinterpret_cast<const char*>(&word), sizeof word);
  }
  return text;
}

// One array of the appended data: its length and bytes, or its one compressed block.
std::string packed(std::span<const char> bytes) {
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

std::string array(const char* type, const char* name, int width, std::size_t offset) {
  return fmt::format(
      "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
      type, name, width, offset);
}

}  // namespace

VtuSeries::VtuSeries(const TetMesh& mesh, const std::vector<NodeIndex>& nodes, bool surface) {
  std::vector<std::int32_t> place(mesh.nodes.size(), -1), connectivity, offsets;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    place[nodes[i]] = static_cast<std::int32_t>(i);
    rest_.push_back(mesh.nodes[nodes[i]].cast<float>());
  }
  const auto add = [&](const auto& cell) {
    for (const NodeIndex node : cell) connectivity.push_back(place[node]);
    offsets.push_back(static_cast<std::int32_t>(connectivity.size()));
  };
  if (surface)
    for (const Triangle& triangle : boundary_triangles(mesh)) add(triangle);
  else
    for (const Tet& tet : mesh.tets) add(tet);
  cells_ = offsets.size();
  constexpr char triangle_type = 5, tet_type = 10;
  node_ = pack(bytes_of(nodes));
  connectivity_ = pack(bytes_of(connectivity));
  offsets_ = pack(bytes_of(offsets));
  types_ = pack(std::string(cells_, surface ? triangle_type : tet_type));
}

VtuSeries::Array VtuSeries::pack(std::span<const char> bytes) {
  Array array{.packed = packed(bytes), .offset = constant_};
  constant_ += array.packed.size();
  return array;
}

std::string VtuSeries::frame(double t, const Vec3& tip, std::span<const float> u) const {
  std::vector<float> points(3 * rest_.size());
  for (std::size_t i = 0; i < rest_.size(); ++i)
    for (unsigned c = 0; c < 3; ++c) points[3 * i + c] = rest_[i][c] + u[3 * i + c];
  const std::string moved = packed({reinterpret_cast<const char*>(u.data()), u.size_bytes()});
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\" "
      "header_type=\"UInt32\"{}>\n<UnstructuredGrid>\n<FieldData>\n"
      "<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n"
      "<DataArray type=\"Float64\" Name=\"tip\" NumberOfComponents=\"3\" NumberOfTuples=\"1\" "
      "format=\"ascii\">{} {} {}</DataArray>\n</FieldData>\n",
      byte_order, compressor, t, tip[0], tip[1], tip[2]);
  text += fmt::format(
      "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData Vectors=\"displacement\">\n",
      rest_.size(), cells_);
  text += array("Float32", "displacement", 3, constant_) + array("Int32", "node", 1, node_.offset) +
          "</PointData>\n<Points>\n" + array("Float32", "position", 3, constant_ + moved.size()) +
          "</Points>\n<Cells>\n" + array("Int32", "connectivity", 1, connectivity_.offset) +
          array("Int32", "offsets", 1, offsets_.offset) + array("UInt8", "types", 1, types_.offset) +
          "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  for (const Array* constant : {&node_, &connectivity_, &offsets_, &types_}) text += constant->packed;
  return text + moved + packed(bytes_of(points)) + "\n</AppendedData>\n</VTKFile>\n";
}

void write_pvd(const std::filesystem::path& file, std::span<const SeriesFile> series) {
  OutputFile out(file);
  out.write(
      fmt::format("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"{}\">\n"
                  "<Collection>\n",
                  byte_order));
  for (const SeriesFile& one : series)
    out.write(fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", one.t, one.file));
  out.write("</Collection>\n</VTKFile>\n");
  out.commit();
}

std::vector<SeriesFile> read_pvd(const std::filesystem::path& file) {
  const Scanner in(read_file(file), file.string());
  const std::string_view text = in.content();
  const auto value = [&](std::string_view tag, std::string_view key) {
    const std::size_t at = tag.find(key), begin = at + key.size();
    const std::size_t end = at == std::string_view::npos ? at : tag.find('"', begin);
    if (end == std::string_view::npos)
      throw InputError({.file = file.string()},
                       "a DataSet has no timestep and file, expected a series of forefeel");
    return tag.substr(begin, end - begin);
  };
  std::vector<SeriesFile> series;
  if (text.find("type=\"Collection\"") == std::string_view::npos)
    throw InputError({.file = file.string()}, "is no collection of VTK, expected a series of forefeel");
  for (std::size_t at = 0; (at = text.find("<DataSet ", at)) != std::string_view::npos; ++at) {
    const std::string_view tag = text.substr(at, std::min(text.find('>', at), text.size()) - at);
    SeriesFile one{.file = std::string(value(tag, " file=\""))};
    if (!parse_real(value(tag, " timestep=\""), one.t) || !std::isfinite(one.t))
      throw InputError({.file = file.string()}, "a DataSet has no time, expected a series of forefeel");
    series.push_back(std::move(one));
  }
  return series;
}

MovedNodes read_moved_nodes(const std::filesystem::path& file) {
  MovedNodes result;
  VtkXmlReader in(Scanner(read_file(file), file.string()), "UnstructuredGrid");
  in.read([&](const VtkXmlPiece& piece) {
    const std::size_t points = in.count(piece, "NumberOfPoints");
    const std::vector<double> moved = in.reals(in.array(piece, "PointData", "displacement"));
    const std::vector<std::int64_t> node = in.integers(in.array(piece, "PointData", "node"));
    if (moved.size() != 3 * points || node.size() != points)
      throw InputError({.file = file.string()},
                       "its displacements do not fit its points, the file is damaged");
    for (std::size_t i = 0; i < points; ++i) {
      if (node[i] < 0 || node[i] > 0x7fffffff)
        throw InputError({.file = file.string()}, fmt::format("names node {}, expected 0 or more", node[i]));
      result.node.push_back(static_cast<NodeIndex>(node[i]));
      result.moved.emplace_back(moved[3 * i], moved[3 * i + 1], moved[3 * i + 2]);
      if (!result.moved.back().allFinite())
        throw InputError({.file = file.string()}, "a displacement is not finite, the file is damaged");
    }
  });
  return result;
}

}  // namespace forefeel
