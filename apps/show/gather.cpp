#include "apps/show/gather.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "apps/scene/given_states.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/show/gather_body.hpp"
#include "apps/show/gather_run.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/mesh/mesh_file.hpp"

namespace forefeel {

namespace {

constexpr double most_cells = 250'000;     // of the grid of one time
constexpr double most_of_all = 1'000'000;  // of the grids of all times

LabelGrid sample(const StateSpace& space, const Box& box, double most, double time) {
  LabelGrid grid{.time = time, .count = {1, 1, 1}, .label = {}};
  const Vec3 size = box.size().cwiseMax(1e-3 * box.size().maxCoeff());
  const double cell = std::max(space.options().spacing / 4, std::cbrt(size.prod() / most));
  Vec3 step;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double n = std::clamp(std::ceil(box.size()[axis] / cell - 1e-6), 1.0, most);
    grid.count[axis] = static_cast<std::uint32_t>(n);
    step[axis] = box.size()[axis] / n;
  }
  const std::uint32_t nx = grid.count[0], ny = grid.count[1], nz = grid.count[2];
  grid.label.resize(std::size_t{nx} * ny * nz);
#pragma omp parallel for schedule(dynamic, 1)
  for (std::uint32_t k = 0; k < nz; ++k) {
    PathWalk walk;
    for (std::uint32_t j = 0; j < ny; ++j)
      for (std::uint32_t i = 0; i < nx; ++i)
        grid.label[(std::size_t{k} * ny + j) * nx + i] =
            space.label(box.low + step.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5)), walk);
  }
  return grid;
}

// The states known at each time, one after the other.
std::vector<LabelGrid> grids(const StateSpaceOptions& options, const std::vector<ShownState>& states,
                             std::span<const double> times) {
  std::vector<const ShownState*> order;
  for (const ShownState& s : states)
    if (s.state.usable()) order.push_back(&s);
  const auto from = [](const ShownState* s) { return std::isnan(s->known) ? -1.0 : s->known; };
  std::ranges::stable_sort(order, {}, from);
  StateSpace space(options);
  std::vector<LabelGrid> result;
  std::size_t next = 0;
  const double most = std::min(most_cells, most_of_all / double(times.size()));
  for (const double time : times) {
    for (; next < order.size() && from(order[next]) <= time; ++next) {
      State light = order[next]->state;
      light.displacements.reset();
      space.insert(std::move(light));
    }
    result.push_back(sample(space, options.box, most, time));
  }
  return result;
}

std::string as_text(const Box& box) {
  return fmt::format("{},{},{}:{},{},{}", box.low.x(), box.low.y(), box.low.z(), box.high.x(), box.high.y(),
                     box.high.z());
}

}  // namespace

void take_states(const Globals& globals, const LabelFrame& frame, std::vector<ShownState> states,
                 std::span<const double> times, ShowContent& content) {
  ClassifyArguments arguments;
  if (std::isfinite(frame.spacing)) arguments.space.spacing = frame.spacing;
  if (frame.box && frame.box->size().minCoeff() > 0) arguments.space.box = as_text(*frame.box);
  std::vector<State> usable;
  for (const ShownState& s : states)
    if (s.state.usable()) usable.push_back(s.state);
  Classified set = prepare_states(arguments, frame.where, std::move(usable), {}, globals);
  label_regions(set, arguments, {.holes = false, .leaves = true, .space = true}, globals);
  ShownStates shown;
  shown.regions = std::move(set.regions);
  for (ShownState& s : states) s.label = set.index.space->label(s.state.at);
  if (times.size() == 1)
    shown.labels.push_back(sample(*set.index.space, set.box, most_cells, times[0]));
  else
    shown.labels = grids(set.index.space->options(), states, times);
  shown.all = std::move(states);
  content.states = std::move(shown);
  content.box = set.box;
  content.spacing = set.spacing;
}

namespace {

namespace fs = std::filesystem;

constexpr std::size_t snapshots = 12;  // of the labels of a run

std::string mm(double metres) {
  return fmt::format("{:.4g} mm", 1e3 * metres);
}

Scene scene_at(const Globals& globals, const std::string& file) {
  return load_scene_with_sites(file, globals.set, {.quiet = globals.quiet});
}

// states: known, of a scene with contact.anywhere.
void take_scene(const Globals& globals, const ShowRequest& request, const Scene& scene,
                std::span<const State> states, ShowContent& content) {
  if (is_anywhere(scene)) {
    content.body = shown_anywhere(scene, globals, request.trust, states);
    return;
  }
  if (request.trust)
    throw InputError("--trust",
                     "is for a body that is touched anywhere, expected a scene with contact.anywhere");
  content.body = shown_body(*scene.body);
  content.box = scene.space.box;
  content.spacing = scene.space.spacing;
}

// States with sites are shown where the tip is, s + x. Returns whether there are any.
bool at_tips(std::vector<ShownState>& states) {
  bool any = false;
  for (ShownState& s : states)
    if (s.state.has_site()) s.state.at += s.state.site, any = true;
  return any;
}

std::vector<State> states_of(const std::vector<ShownState>& shown) {
  std::vector<State> states;
  for (const ShownState& s : shown) states.push_back(s.state);
  return states;
}

ShowContent of_scene(const Globals& globals, const ShowRequest& request) {
  const std::string& file = request.what;
  const Scene scene = scene_at(globals, file);
  ShowContent content;
  content.kind = "scene";
  take_scene(globals, request, scene, {}, content);
  content.warnings = scene.source.warnings;
  content.title =
      fmt::format("{}: {} elements, {}", fs::path(file).filename().string(), scene.body->mesh.tets.size(),
                  is_anywhere(scene) ? "pressed anywhere" : "spacing " + mm(scene.space.spacing));
  return content;
}

ShowContent of_mesh(const std::string& file) {
  TetMesh mesh = read_mesh(file);
  const MeshCheck check = check_and_orient(mesh, file);
  ShowContent content;
  content.kind = "mesh";
  for (const std::string& warning : check.warnings) content.warnings.push_back(file + ": " + warning);
  content.title = fmt::format("{}: {} elements, {} nodes, {} long", fs::path(file).filename().string(),
                              mesh.tets.size(), mesh.nodes.size(), mm(longest_side(mesh)));
  content.body = shown_body(mesh);
  return content;
}

ShowContent of_surface(const std::string& file) {
  const Surface surface = read_surface(file);
  if (surface.triangles.empty())
    throw InputError({.file = file}, "holds no triangles, expected some to show");
  ShowContent content;
  content.kind = "surface";
  content.title =
      fmt::format("{}: {} triangles, {} nodes (surface, unscaled)", fs::path(file).filename().string(),
                  surface.triangles.size(), surface.nodes.size());
  content.body = shown_body(surface);
  return content;
}

// A scene beside states gives the body, the box and the spacing.
LabelFrame with_scene(const Globals& globals, const ShowRequest& request, const Scene& scene,
                      const BodyIdentity& identity, const std::vector<ShownState>& states, LabelFrame frame,
                      ShowContent& content) {
  const std::vector<State> all = states_of(states);
  belonging_of(globals, scene, frame.where, identity, all, request.foreign);
  take_scene(globals, request, scene, all, content);
  for (const std::string& warning : scene.source.warnings) content.warnings.push_back(warning);
  frame.spacing = scene.space.spacing;
  frame.box = scene.space.box;
  return frame;
}

ShowContent of_states(const Globals& globals, const ShowRequest& request) {
  ShowContent content;
  content.kind = "states";
  std::vector<ShownState> states;
  LabelFrame frame{.where = request.what, .spacing = unknown, .box = {}};
  BodyIdentity identity;
  MadeBy own;
  const auto take = [&](std::vector<State> all) {
    for (State& state : all) {
      if (!state.at.allFinite()) continue;
      states.emplace_back();
      states.back().state = std::move(state);
    }
  };
  if (request.what.starts_with("setup:")) {
    StatesInFrame set = load_set(request.what);
    take(std::move(set.states));
    frame.spacing = set.own.spacing;
    frame.box = set.own.box;
  } else {
    LoadedStates loaded = load_states(request.what, Tells::places);
    if (loaded.damaged > 0) content.warnings.push_back(damage_in_words(request.what, loaded.damaged));
    identity = loaded.header.identity;
    frame.spacing = loaded.header.spacing;
    if (loaded.header.box.size().minCoeff() > 0) frame.box = loaded.header.box;
    take(std::move(loaded.states));
    if (const auto note = loaded.header.notes.find("provenance"); note != loaded.header.notes.end())
      own = made_by(note->second);
  }
  if (!request.scene.empty())
    frame = with_scene(globals, request, scene_at(globals, request.scene), identity, states, frame, content);
  else if (const std::optional<Scene> scene = scene_of(own); scene && scene->identity == identity)
    take_scene(globals, request, *scene, states_of(states), content);
  if (states.empty()) throw InputError({.file = request.what}, "holds no state, expected some to show");
  if (at_tips(states)) frame.box.reset();
  const double now = 0;
  take_states(globals, frame, std::move(states), {&now, 1}, content);
  content.title = fmt::format("{}: {} states, spacing {}", fs::path(request.what).filename().string(),
                              content.states->all.size(), mm(content.spacing));
  return content;
}

// Times at which the labels are taken: evenly from begin to end.
std::vector<double> moments(const ShownRun& run) {
  std::vector<double> times;
  const double begin = run.path.front().t, end = run.path.back().t;
  for (std::size_t i = 0; i < snapshots; ++i)
    times.push_back(begin + (end - begin) * double(i) / double(snapshots - 1));
  times.back() = end;
  return times;
}

ShowContent of_run(const Globals& globals, const ShowRequest& request) {
  RunFolder run = read_run(request.what);
  ShowContent content;
  content.kind = "run";
  LabelFrame frame{.where = request.what, .spacing = run.spacing, .box = run.box};
  if (!request.scene.empty()) {
    frame = with_scene(globals, request, scene_at(globals, request.scene), run.identity, run.states, frame,
                       content);
  } else if (const std::optional<Scene> scene = scene_of(run.made_by)) {
    take_scene(globals, request, *scene, states_of(run.states), content);
    frame.box = scene->space.box;
  } else {
    content.warnings.push_back(fmt::format(
        "{}: the scene of this run was not found, so its body is not shown; --scene SCENE shows it",
        request.what));
  }
  if (content.body) run.run.shapes = shapes_of_run(run, *content.body);
  content.spacing = frame.spacing;
  content.box = frame.box;
  const std::size_t known = run.states.size();
  if (at_tips(run.states)) frame.box.reset();
  if (!run.states.empty()) take_states(globals, frame, std::move(run.states), moments(run.run), content);
  content.run = std::move(run.run);
  const fs::path folder = fs::path(request.what).lexically_normal();
  content.title =
      fmt::format("{}: {:.4g} s, {} frames, {} states",
                  (folder.has_filename() ? folder : folder.parent_path()).filename().string(),
                  content.run->path.back().t - content.run->path.front().t, content.run->frames, known);
  return content;
}

}  // namespace

ShowContent gather(const Globals& globals, const ShowRequest& request) {
  std::error_code error;
  if (fs::is_directory(request.what, error)) {
    if (!is_run_folder(request.what))
      throw InputError({.file = request.what},
                       "is a folder without frames.csv, expected the folder of a session");
    return of_run(globals, request);
  }
  if (request.what.starts_with("setup:")) return of_states(globals, request);
  const std::string start = read_start(request.what, 16);  // reports a file that is missing or empty
  const std::string extension = lower_case(fs::path(request.what).extension().string());
  if (start.starts_with("SQLite format 3") || extension == ".states" || extension == ".csv")
    return of_states(globals, request);
  if (!request.scene.empty())
    throw InputError("--scene", "gives the body of states or of a run, expected one of these to show");
  if (extension == ".toml") return of_scene(globals, request);
  if (is_surface_file(request.what)) return of_surface(request.what);
  if (is_mesh_file(request.what)) return of_mesh(request.what);
  throw InputError(
      {.file = request.what},
      "unknown kind of file, expected a scene (.toml), a mesh (.msh .vtk .vtu .mesh), a surface (.obj "
      ".off .stl .ply .vtk), states (.states .csv) or the folder of a run");
}

}  // namespace forefeel
