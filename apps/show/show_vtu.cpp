#include "apps/show/show_vtu.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/common/declared.hpp"
#include "geometry/coverage/region_file.hpp"
#include "geometry/mesh/vtu_writer.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

// a(y) [N/m^3], or the stiffness [N/m], at the nodes; where facets at an edge differ, the largest.
std::vector<double> pad_at_nodes(const ShownBody& body, std::size_t nodes) {
  std::vector<double> density(nodes, 0.0);
  const ShownPad& pad = *body.pad;
  for (std::size_t p = 0; p < pad.facet.size(); ++p)
    for (int i = 0; i < 3; ++i)
      if (pad.at[p][i] == 1) {
        const NodeIndex corner = body.triangles[pad.facet[p]][static_cast<std::size_t>(i)];
        double& own = density[body.node[corner]];
        own = std::max(own, pad.least + pad.weight[p] * (pad.peak - pad.least));
      }
  return density;
}

void write_body(const fs::path& file, const ShownBody& body) {
  const bool solid = !body.mesh.tets.empty();
  std::vector<Vec3> points = solid ? body.mesh.nodes : body.nodes;
  if (solid)
    for (Vec3& p : points) p -= body.rest;
  std::vector<std::uint8_t> role(points.size(), 0);
  for (std::size_t i = 0; i < body.node.size(); ++i)
    role[static_cast<std::size_t>(body.node[i])] = static_cast<std::uint8_t>(body.role[i]);
  VtuWriter grid(file, VtuData::text);
  grid.begin(points.size(), solid ? body.mesh.tets.size() : body.triangles.size());
  grid.section("PointData");
  grid.array<std::uint8_t>("role", 1, role);
  if (body.pad)
    grid.array<double>(body.pad->shade == PadShade::springs ? "pad" : std::string(name(body.pad->shade)), 1,
                       pad_at_nodes(body, points.size()));
  for (const auto& [name, nodes] : body.mesh.groups) {
    std::vector<std::uint8_t> in(points.size(), 0);
    for (const NodeIndex node : nodes) in[node] = 1;
    grid.array<std::uint8_t>("group_" + name, 1, in);
  }
  if (solid && !body.regions.all.empty()) {
    grid.section("CellData");
    grid.array<std::uint8_t>("region", 1, body.regions.of_tet);
    for (std::size_t k = 0; k < body.regions.all.size(); ++k)
      grid.array<std::uint8_t>("region_" + body.regions.all[k].name, body.regions.of_tet.size(), 1,
                               [&](std::size_t i, int) { return body.regions.of_tet[i] == k + 1; });
  }
  grid.points(points);
  if (solid)
    grid.cells(body.mesh.tets, vtk_cell::tetra);
  else
    grid.cells(body.triangles, vtk_cell::triangle);
  grid.finish();
}

void write_path(const fs::path& file, const ShownRun& run) {
  const std::vector<ShownFrame>& path = run.path;
  std::vector<std::array<std::size_t, 2>> pieces;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) pieces.push_back({i, i + 1});
  VtuWriter grid(file, VtuData::text);
  grid.begin(path.size(), pieces.size());
  grid.section("PointData");
  const auto value = [&](const char* name, auto&& of) {
    grid.array<double>(name, path.size(), 1, [&](std::size_t i, int) { return of(path[i]); });
  };
  value("time", [](const ShownFrame& f) { return f.t; });
  grid.array<double>("force", path.size(), 3, [&](std::size_t i, int k) { return path[i].sent[k]; });
  grid.array<std::uint8_t>("label", path.size(), 1, [&](std::size_t i, int) { return path[i].label; });
  if (std::ranges::any_of(path, [](const ShownFrame& f) { return std::isfinite(f.error); }))
    value("error", [](const ShownFrame& f) { return f.error; });
  std::vector<Vec3> points;
  for (const ShownFrame& f : path) points.push_back(f.at);
  grid.points(points);
  grid.cells(pieces, vtk_cell::line);
  grid.finish();
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
