#include "apps/show/show_vtu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "apps/picture/page.hpp"
#include "geometry/common/declared.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/coverage/region_file.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

// An unstructured grid of cells of one kind, as text.
class TextGrid {
 public:
  TextGrid(const fs::path& file, std::size_t points, std::size_t cells) : out_(file) {
    out_.write(
        fmt::format("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
                    "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece "
                    "NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
                    points, cells));
  }
  void open(std::string_view part) { out_.write(fmt::format("<{}>\n", part)); }
  void close(std::string_view part) { out_.write(fmt::format("</{}>\n", part)); }

  // value(i, k): component k of item i.
  template <class Value>
  void array(std::string_view type, const std::string& name, std::size_t items, int width, Value&& value) {
    out_.write(fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n",
                           type, html_escaped(name), width));
    std::string text;
    for (std::size_t i = 0; i < items; ++i) {
      for (int k = 0; k < width; ++k) text += fmt::format("{} ", value(i, k));
      text += '\n';
      if (text.size() > (1u << 20)) out_.write(text), text.clear();
    }
    out_.write(text + "</DataArray>\n");
  }
  void points(const std::vector<Vec3>& all) {
    open("Points");
    array("Float64", "position", all.size(), 3, [&](std::size_t i, int k) { return all[i][k]; });
    close("Points");
  }
  template <class Cell>
  void cells(const std::vector<Cell>& all, int type) {
    const std::size_t corners = all.empty() ? 0 : all[0].size();
    open("Cells");
    array("Int64", "connectivity", all.size() * corners, 1,
          [&](std::size_t i, int) { return static_cast<long long>(all[i / corners][i % corners]); });
    array("Int64", "offsets", all.size(), 1,
          [&](std::size_t i, int) { return static_cast<long long>((i + 1) * corners); });
    array("UInt8", "types", all.size(), 1, [&](std::size_t, int) { return type; });
    close("Cells");
  }
  void commit() {
    out_.write("</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    out_.commit();
  }

 private:
  OutputFile out_;
};

constexpr int vtk_line = 3, vtk_triangle = 5, vtk_tetra = 10;

void write_body(const fs::path& file, const ShownBody& body) {
  const bool solid = !body.mesh.tets.empty();
  std::vector<Vec3> points = solid ? body.mesh.nodes : body.nodes;
  if (solid)
    for (Vec3& p : points) p -= body.rest;
  std::vector<int> role(points.size(), 0);
  for (std::size_t i = 0; i < body.node.size(); ++i) role[body.node[i]] = static_cast<int>(body.role[i]);
  TextGrid grid(file, points.size(), solid ? body.mesh.tets.size() : body.triangles.size());
  grid.open("PointData");
  grid.array("UInt8", "role", role.size(), 1, [&](std::size_t i, int) { return role[i]; });
  for (const auto& [name, nodes] : body.mesh.groups) {
    std::vector<int> in(points.size(), 0);
    for (const NodeIndex node : nodes) in[node] = 1;
    grid.array("UInt8", "group_" + name, in.size(), 1, [&](std::size_t i, int) { return in[i]; });
  }
  grid.close("PointData");
  if (solid && !body.regions.empty()) {
    grid.open("CellData");
    grid.array("UInt8", "region", body.tet_region.size(), 1,
               [&](std::size_t i, int) { return int{body.tet_region[i]}; });
    for (std::size_t k = 0; k < body.regions.size(); ++k)
      grid.array("UInt8", "region_" + body.regions[k].name, body.tet_region.size(), 1,
                 [&](std::size_t i, int) { return body.tet_region[i] == k + 1 ? 1 : 0; });
    grid.close("CellData");
  }
  grid.points(points);
  if (solid)
    grid.cells(body.mesh.tets, vtk_tetra);
  else
    grid.cells(body.triangles, vtk_triangle);
  grid.commit();
}

void write_path(const fs::path& file, const ShownRun& run) {
  const std::vector<ShownFrame>& path = run.path;
  std::vector<std::array<std::size_t, 2>> pieces;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) pieces.push_back({i, i + 1});
  TextGrid grid(file, path.size(), pieces.size());
  grid.open("PointData");
  const auto value = [&](const char* name, auto&& of) {
    grid.array("Float64", name, path.size(), 1, [&](std::size_t i, int) { return of(path[i]); });
  };
  value("time", [](const ShownFrame& f) { return f.t; });
  grid.array("Float64", "force", path.size(), 3, [&](std::size_t i, int k) { return path[i].sent[k]; });
  grid.array("UInt8", "label", path.size(), 1,
             [&](std::size_t i, int) { return static_cast<int>(path[i].label); });
  if (std::ranges::any_of(path, [](const ShownFrame& f) { return std::isfinite(f.error); }))
    value("error", [](const ShownFrame& f) { return f.error; });
  grid.close("PointData");
  std::vector<Vec3> points;
  for (const ShownFrame& f : path) points.push_back(f.at);
  grid.points(points);
  grid.cells(pieces, vtk_line);
  grid.commit();
}

struct Names {
  fs::path body, labels, states, path;  // empty: not written
};

Names names_of(const fs::path& file, const ShowContent& content) {
  const auto beside = [&](const char* what) {
    return file.parent_path() / (file.stem().string() + what + file.extension().string());
  };
  Names names;
  if (content.body) names.body = file;
  if (content.states) {
    names.labels = content.body ? beside("_labels") : file;
    names.states = beside("_states");
  }
  if (content.run) names.path = content.body || content.states ? beside("_path") : file;
  return names;
}

}  // namespace

std::vector<fs::path> show_vtu_files(const fs::path& file, const ShowContent& content) {
  const Names names = names_of(file, content);
  std::vector<fs::path> all;
  for (const fs::path& name : {names.body, names.labels, names.states, names.path})
    if (!name.empty()) all.push_back(name);
  return all;
}

std::vector<fs::path> write_show_vtu(const fs::path& file, const ShowContent& content) {
  const Names names = names_of(file, content);
  if (!names.body.empty()) write_body(names.body, *content.body);
  if (!names.labels.empty()) {
    const RegionSummary& regions = content.states->regions;
    write_regions_vtu(names.labels, regions.leaves, regions.components);
    std::vector<State> states;
    for (const ShownState& s : content.states->all) states.push_back(s.state);
    write_states_vtu(names.states, states);
  }
  if (!names.path.empty()) write_path(names.path, *content.run);
  return show_vtu_files(file, content);
}

}  // namespace forefeel
