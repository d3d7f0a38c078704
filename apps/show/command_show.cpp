// forefeel show: an interactive 3-D picture of a body, states or a run; or files for ParaView.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/values.hpp"
#include "apps/picture/figure_files.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/show/gather.hpp"
#include "apps/show/show_content.hpp"
#include "apps/show/show_page.hpp"
#include "geometry/common/declared.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/coverage/region_file.hpp"
#include "geometry/mesh/vtu_writer.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {

namespace {

// Files for ParaView of what `forefeel show` shows, in positions of the HIP [m].

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

// The names of these files, without writing them.
std::vector<fs::path> show_vtu_files(const fs::path& file, const ShowContent& content) {
  const Names names = names_of(file, content);
  std::vector<fs::path> all;
  for (const fs::path& name : {names.body, names.labels, names.states, names.path})
    if (!name.empty()) all.push_back(name);
  return all;
}

// OUT.vtu: the body, with point data role (0 free, 1 clamp, 2 contact) and group_NAME. Beside it, where there are
// any: OUT_labels.vtu (regions), OUT_states.vtu, OUT_path.vtu (time, force, label, error). Without a body OUT.vtu
// holds the labels, or else the path. Returns the names of the files.
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

namespace fs = std::filesystem;

struct ShowArguments {
  ShowRequest request;
  std::string output, palette{usual_palette};
};

struct ShowResult {
  ShowContent content;
  std::vector<fs::path> files;
  std::uintmax_t size_bytes = 0;
  double seconds = 0;
};

void check_arguments(const Globals& globals, const ShowArguments& arguments) {
  const std::string extension = lower_case(fs::path(arguments.output).extension().string());
  constexpr std::array<std::string_view, 2> known{".html", ".vtu"};
  if (std::ranges::find(known, extension) == known.end())
    throw InputError(arguments.output,
                     fmt::format("has the ending '{}', expected {}", extension, fmt::join(known, " or ")));
  if (arguments.request.foreign && arguments.request.scene.empty())
    throw InputError("--foreign", "is about states beside a scene, expected it with --scene");
  if (arguments.request.trust && !(*arguments.request.trust < 1))
    throw InputError("--trust",
                     fmt::format("is {:g} m, expected a depth in metres", *arguments.request.trust));
  const bool scene = lower_case(fs::path(arguments.request.what).extension().string()) == ".toml";
  if (!globals.set.empty() && arguments.request.scene.empty() && !scene)
    throw InputError("--set", "overrides keys of a scene, expected it with a scene, or with --scene");
  std::error_code error;
  if (fs::is_directory(arguments.request.what, error))
    check_writable(arguments.output);
  else
    check_writable(arguments.output, {arguments.request.what, arguments.request.scene});
}

ShowResult make(const Globals& globals, const ShowArguments& arguments) {
  const auto begin = std::chrono::steady_clock::now();
  ShowResult result;
  Progress progress(globals, "show");
  progress.show("reading " + arguments.request.what);
  result.content = gather(globals, arguments.request);
  progress.show("writing " + arguments.output);
  const std::string extension = lower_case(fs::path(arguments.output).extension().string());
  if (extension == ".vtu") {
    result.files = write_show_vtu(arguments.output, result.content);
  } else {
    write_whole(arguments.output, show_page(result.content, arguments.output));
    result.files = {arguments.output};
  }
  for (const fs::path& file : result.files) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(file, error);
    if (!error) result.size_bytes += size;
  }
  result.seconds = seconds_since(begin);
  return result;
}

nlohmann::ordered_json show_json(const ShowResult& result) {
  using Json = nlohmann::ordered_json;
  const ShowContent& content = result.content;
  nlohmann::ordered_json out{{"kind", content.kind}, {"files", nlohmann::ordered_json::array()}};
  for (const fs::path& file : result.files) out["files"].push_back(file.string());
  out["size_bytes"] = result.size_bytes;
  out["seconds"] = result.seconds;
  out["body"] = nullptr;
  if (content.body) {
    const ShownBody& body = *content.body;
    const auto of_shade = [&](PadShade shade) { return body.pad && body.pad->shade == shade; };
    nlohmann::ordered_json groups = nlohmann::ordered_json::array();
    for (const ShownGroup& group : body.groups) groups.push_back(group.name);
    out["body"] = {
        {"nodes", body.nodes.size()},
        {"triangles", body.triangles.size()},
        {"elements", body.mesh.tets.size()},
        {"clamp", std::ranges::count(body.role, Role::clamp)},
        {"contact", std::ranges::count(body.role, Role::contact)},
        {"pad", of_shade(PadShade::springs) ? number(body.pad->peak) : Json()},
        {"stiffness",
         of_shade(PadShade::stiffness) ? Json{number(body.pad->least), number(body.pad->peak)} : Json()},
        {"untrusted", of_shade(PadShade::error) ? number(body.pad->share) : Json()},
        {"groups", groups},
        {"regions", nlohmann::ordered_json::array()}};
    for (const ShownRegion& region : body.regions.all)
      out["body"]["regions"].push_back({{"name", region.name}, {"volume", region.volume}});
  }
  out["box"] = nullptr;
  if (content.box) out["box"] = {vector3(content.box->low), vector3(content.box->high)};
  out["spacing"] = number(content.spacing);
  out["states"] = content.states ? content.states->all.size() : 0;
  out["moments"] = content.states ? content.states->labels.size() : 0;
  out["frames"] = content.run ? content.run->frames : 0;
  out["frames_shown"] = content.run ? content.run->path.size() : 0;
  out["shapes"] = content.run ? content.run->shapes.size() : 0;
  out["warnings"] = content.warnings;
  return out;
}

int run_show(const Globals& globals, const ShowArguments& arguments) {
  check_arguments(globals, arguments);
  use_palette(arguments.palette);
  const ShowResult result = make(globals, arguments);
  for (const std::string& warning : result.content.warnings) warn(globals, warning);
  if (globals.json) print_json(show_json(result));
  std::vector<std::string> names;
  for (const fs::path& file : result.files) names.push_back(file.string());
  say(globals, fmt::format("{}: {} ({:.3g} MB, {:.2g} s)", result.content.title, fmt::join(names, ", "),
                           1e-6 * static_cast<double>(result.size_bytes), result.seconds));
  flush_warnings();
  return 0;
}

}  // namespace

void add_show(CommandLine& line) {
  const auto arguments = std::make_shared<ShowArguments>();
  Command sub =
      line.add("show", "Show a scene, a mesh, states or a run: a picture that can be turned and zoomed");
  sub.runs([arguments](const Globals& globals) {
    std::error_code error;
    const fs::path what = arguments->request.what;
    if (arguments->output.empty() && fs::is_directory(what, error))
      arguments->output = (what / "show.html").string();
    if (arguments->output.empty())
      throw InputError("show",
                       "-o is missing, expected OUT.html or OUT.vtu; of the folder of a run RUN/show.html is "
                       "made without it");
    return run_show(globals, *arguments);
  });
  sub.option("WHAT", arguments->request.what,
             "Scene (.toml), mesh, surface, states (.states .csv) or the folder of a run")
      .required()
      .shows("SCENE|MESH|STATES|RUN/");
  sub.option("-o,--output", arguments->output,
             "One page for a browser, which needs no network (.html), or files for ParaView (.vtu) [of a run "
             "RUN/show.html]")
      .shows("OUT");
  sub.option(
         "--scene", arguments->request.scene,
         "The scene of these states or of this run, for the body and the box; default: a run's own, if it is "
         "unchanged")
      .shows("SCENE");
  sub.flag("--foreign", arguments->request.foreign, foreign_help);
  sub.option("--trust", arguments->request.trust,
             "With contact.anywhere: colour the body by the estimated error of the force this deep [m], in "
             "place of "
             "its stiffness; the states shown count")
      .shows("DEPTH")
      .check(above_zero);
  add_palette(sub, arguments->palette);
}

}  // namespace forefeel
