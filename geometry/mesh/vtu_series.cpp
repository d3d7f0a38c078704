#include "geometry/mesh/vtu_series.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/mesh/vtk_xml.hpp"
#include "geometry/mesh/vtu_writer.hpp"

namespace forefeel {
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
  const auto pack = [](const auto& values) {
    return VtuWriter::pack({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])});
  };
  node_ = pack(nodes);
  connectivity_ = pack(connectivity);
  offsets_ = pack(offsets);
  types_ = pack(std::vector<std::uint8_t>(cells_, surface ? vtk_cell::triangle : vtk_cell::tetra));
}

std::string VtuSeries::frame(double t, const Vec3& tip, std::span<const float> u) const {
  std::vector<float> points(3 * rest_.size());
  for (std::size_t i = 0; i < rest_.size(); ++i)
    for (unsigned c = 0; c < 3; ++c) points[3 * i + c] = rest_[i][c] + u[3 * i + c];
  std::string text;
  VtuWriter out(text, VtuData::packed);
  out.begin(
      rest_.size(), cells_,
      fmt::format("<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
                  "format=\"ascii\">{}</DataArray>\n"
                  "<DataArray type=\"Float64\" Name=\"tip\" NumberOfComponents=\"3\" NumberOfTuples=\"1\" "
                  "format=\"ascii\">{} {} {}</DataArray>\n",
                  t, tip[0], tip[1], tip[2]));
  out.section("PointData", "Vectors=\"displacement\"");
  out.array<float>("displacement", 3, u);
  out.packed_array("Int32", "node", 1, node_);
  out.section("Points");
  out.array<float>("position", 3, points);
  out.section("Cells");
  out.packed_array("Int32", "connectivity", 1, connectivity_);
  out.packed_array("Int32", "offsets", 1, offsets_);
  out.packed_array("UInt8", "types", 1, types_);
  out.finish();
  return text;
}

void write_pvd(const std::filesystem::path& file, std::span<const SeriesFile> series) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "<Collection>\n";
  for (const SeriesFile& one : series)
    text += fmt::format("<DataSet timestep=\"{}\" group=\"\" part=\"{}\" file=\"{}\"/>\n", one.t, one.part,
                        one.file);
  write_whole(file, text + "</Collection>\n</VTKFile>\n");
}

std::vector<SeriesFile> read_pvd(const std::filesystem::path& file) {
  Scanner in(read_file(file), file.string());
  std::vector<SeriesFile> series;
  bool collection = false;
  for (XmlTag tag; next_xml_tag(in, tag);) {
    if (tag.name == "VTKFile") collection = tag.attribute("type") == "Collection";
    if (tag.name != "DataSet") continue;
    SeriesFile one{.file = tag.attribute("file")};
    if (one.file.empty())
      throw InputError({.file = file.string()}, "a DataSet has no file, expected a series of forefeel");
    if (!parse_real(tag.attribute("timestep"), one.t) || !std::isfinite(one.t))
      throw InputError({.file = file.string()}, "a DataSet has no time, expected a series of forefeel");
    series.push_back(std::move(one));
  }
  if (!collection)
    throw InputError({.file = file.string()}, "is no collection of VTK, expected a series of forefeel");
  return series;
}

MovedNodes read_moved_nodes(const std::filesystem::path& file) {
  MovedNodes result;
  std::string content = read_file(file);
  if (!trimmed(content).ends_with("</VTKFile>"))
    throw InputError({.file = file.string()}, "ends before </VTKFile>, the file is cut short");
  VtkXmlReader in(Scanner(std::move(content), file.string()), "UnstructuredGrid");
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
