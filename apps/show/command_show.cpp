// forefeel show: an interactive 3-D picture of a body, states or a run; or files for ParaView.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/values.hpp"
#include "apps/picture/figure_files.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/show/gather.hpp"
#include "apps/show/show_page.hpp"
#include "apps/show/show_vtu.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/scanner.hpp"

namespace forefeel {
namespace {

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
  result.content = gather(globals, arguments.request);
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

nlohmann::ordered_json to_json(const ShowResult& result) {
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
  if (globals.json) print_json(to_json(result));
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
  sub.runs([arguments](const Globals& globals) { return run_show(globals, *arguments); });
  sub.option("WHAT", arguments->request.what,
             "Scene (.toml), mesh, surface, states (.states .csv) or the folder of a run")
      .required()
      .shows("SCENE|MESH|STATES|RUN/");
  sub.option("-o,--output", arguments->output,
             "One page for a browser, which needs no network (.html), or files for ParaView (.vtu)")
      .required()
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
