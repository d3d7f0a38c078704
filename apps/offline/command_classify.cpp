// forefeel classify: shows where the force is known from states. Labels and measures at points, regions with
// volumes, pictures, files for ParaView; a run over time; the difference of two sets.

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/outputs.hpp"
#include "apps/console/spacing_check.hpp"
#include "apps/console/units.hpp"
#include "apps/console/values.hpp"
#include "apps/offline/calibrate_labels.hpp"
#include "apps/offline/classify.hpp"
#include "apps/offline/classify_sites.hpp"
#include "apps/offline/error_known.hpp"
#include "apps/offline/offline_bars.hpp"
#include "apps/offline/print_classified.hpp"
#include "apps/picture/coverage_picture.hpp"
#include "apps/picture/figure_files.hpp"
#include "apps/scene/given_states.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/field.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/coverage/region_file.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

// X,Y,Z:X,Y,Z:N
std::vector<Vec3> parse_line(const std::string& text) {
  const std::size_t first = text.find(':'),
                    second = first == std::string::npos ? first : text.find(':', first + 1);
  const auto refuse = [&] {
    return InputError("--line", fmt::format("'{}' is not a line, expected X,Y,Z:X,Y,Z:N with N >= 2", text));
  };
  if (second == std::string::npos) throw refuse();
  const Vec3 a = parse_vector(text.substr(0, first), "--line");
  const Vec3 b = parse_vector(text.substr(first + 1, second - first - 1), "--line");
  std::size_t used = 0;
  long n = 0;
  try {
    n = std::stol(text.substr(second + 1), &used);
  } catch (const std::exception&) {
    throw refuse();
  }
  if (n < 2 || n > 100'000'000 || used != text.size() - second - 1) throw refuse();
  std::vector<Vec3> points;
  for (long i = 0; i < n; ++i) points.push_back(a + (b - a) * (double(i) / double(n - 1)));
  return points;
}

std::vector<Vec3> grid_points(const Classified& set, double step) {
  const Box& box = set.box;
  std::array<long, 3> count{};
  double total = 1;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double n = std::floor(box.size()[axis] / step + 1e-9) + 1;
    total *= n;
    if (!(total <= 1e8)) throw InputError("--grid", "gives more than 1e8 points, expected a wider grid");
    count[axis] = static_cast<long>(n);
  }
  std::vector<Vec3> points;
  points.reserve(static_cast<std::size_t>(total));
  for (long k = 0; k < count[2]; ++k)
    for (long j = 0; j < count[1]; ++j)
      for (long i = 0; i < count[0]; ++i)
        points.push_back(set.turn.transpose() * (box.low + step * Vec3(double(i), double(j), double(k))));
  return points;
}

std::vector<Coverage> cover(const Classified& set, const std::vector<Vec3>& points, Progress& progress) {
  constexpr std::size_t run = 64;
  std::vector<Coverage> result(points.size());
  std::size_t done = 0;
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t first = 0; first < points.size(); first += run) {
    for (std::size_t i = first; i < std::min(first + run, points.size()); ++i)
      result[i] = set.coverage(points[i]);
    std::size_t now = 0;
#pragma omp atomic capture
    now = done += run;
    if (omp_get_thread_num() == 0)
      progress.show(std::min(1.0, static_cast<double>(now) / static_cast<double>(points.size())), "points");
  }
  return result;
}

struct PointRow {
  const Vec3& at;
  const Coverage& found;
  const ErrorKnown* errors;
  std::size_t i;  // of the point
};

std::vector<Field<PointRow>> point_columns(bool barred) {
  using R = PointRow;
  std::vector<Field<R>> columns{
      {"x,y,z", "m", "position", [](Cells& o, const R& r) { put(o, r.at); }},
      {"label", "", "safe, sparse, gap or blank", [](Cells& o, const R& r) { put(o, r.found.label); }},
      {"spread", "m", "sqrt(R^2 - d^2) in its Delaunay cell: R circumradius, d distance to the circumcentre",
       [](Cells& o, const R& r) { put(o, r.found.spread); }},
      {"alpha", "m", "circumradius of the cell, the least where several touch",
       [](Cells& o, const R& r) { put(o, r.found.alpha); }},
      {"delta", "m", "distance to the nearest state", [](Cells& o, const R& r) { put(o, r.found.delta); }},
      {"gamma_deg", "degrees", "half-angle of the largest empty cone of directions to states within 8 h",
       [](Cells& o, const R& r) { put(o, r.found.gamma_deg); }}};
  if (!barred) return columns;
  static const std::string meaning = "with --bars: " + std::string(bar_meaning);
  columns.push_back(
      {"bar90,bar95,bar99", "N", meaning, [](Cells& o, const R& r) { o.vector(bar_of(*r.errors, r.i)); }});
  columns.push_back({"known", "", "with --bars: 1 where bar95 is at most the tolerance, else 0",
                     [](Cells& o, const R& r) { put(o, is_known(*r.errors, r.i)); }});
  return columns;
}

void write_points(const std::string& file, const std::vector<Vec3>& points,
                  const std::vector<Coverage>& found, const std::optional<ErrorKnown>& errors) {
  const std::vector<Field<PointRow>> columns = point_columns(errors && errors->points);
  OutputFile out(file);
  out.write(header_of<PointRow>(columns));
  write_lines(out, points.size(), [&](std::size_t i) {
    return csv_row<PointRow>(columns, {points[i], found[i], errors ? &*errors : nullptr, i});
  });
  out.commit();
}

CoveragePicture picture_of(const Classified& set, const ClassifyArguments& arguments) {
  CoveragePicture picture;
  picture.box = set.box;
  picture.through = !arguments.places.through.empty()
                        ? Vec3(set.turn * parse_vector(arguments.places.through, "--through"))
                    : set.box.contains(Vec3::Zero()) ? Vec3(Vec3::Zero())
                                                     : set.box.centre();
  picture.spacing = set.spacing;
  for (const State& s : set.states) picture.states.push_back(set.turn * s.at);
  picture.label = [&set](const Vec3& q) { return set.region_label(q); };
  picture.volume = set.regions.volume;
  picture.components = set.regions.component_count;
  picture.title =
      fmt::format("Coverage of {} ({}, h = {})", fs::path(arguments.input.states).filename().string(),
                  arguments.space.index, Units(set.spacing).distance(set.spacing));
  picture.body = set.body;
  return picture;
}

// The .vtu holds the regions; states and Delaunay cells are in files beside it.
void write_vtu(const Classified& set, const std::string& file, const Globals& globals,
               const std::optional<ErrorKnown>& errors) {
  const fs::path path = file;
  const auto beside = [&](const char* what) {
    return path.parent_path() / (path.stem().string() + what + path.extension().string());
  };
  const Mat3 back = set.turn.transpose();
  write_regions_vtu(path, set.regions.leaves, set.regions.components, back);
  write_states_vtu(beside("_states"), set.states);
  if (set.index.space) write_cells_vtu(beside("_cells"), *set.index.space, back);
  if (errors && errors->box.bars) {
    write_left_out_vtu(beside("_left_out"), *errors->box.bars->measured);
    say(globals, fmt::format("{} (forces left out)", beside("_left_out").string()));
  }
  say(globals, fmt::format("{} (regions), {} (states){}", file, beside("_states").string(),
                           set.index.space ? ", " + beside("_cells").string() + " (Delaunay cells)" : ""));
}

void write_output(const Classified& set, const ClassifyArguments& arguments, const std::vector<Vec3>& points,
                  const std::vector<Coverage>& found, const std::optional<ErrorKnown>& errors,
                  const Globals& globals) {
  const std::string extension = fs::path(arguments.output).extension();
  if (extension == ".vtu")
    return write_vtu(set, arguments.output, globals, arguments.bars ? errors : std::nullopt);
  if (extension == ".svg" || extension == ".png" || extension == ".pdf") {
    write_coverage_picture(arguments.output, picture_of(set, arguments));
  } else if (points.empty()) {
    write_regions_csv(arguments.output, set.regions.leaves, set.turn.transpose());
  } else {
    write_points(arguments.output, points, found, errors);
  }
}

// Refuses options that would have no effect.
void check_effect(const Globals& globals, const ClassifyArguments& arguments, bool run) {
  const std::string extension = fs::path(arguments.output).extension();
  if (!run && (!arguments.input.known.empty() || arguments.places.snapshots))
    throw InputError(arguments.input.known.empty() ? "--snapshots" : "--known",
                     "is for the folder of a run, expected classify RUN/");
  if (!globals.set.empty() && arguments.input.scene.empty())
    throw InputError("--set", "overrides keys of a scene, expected it with --scene or --calibrate");
  if (arguments.input.foreign && arguments.input.scene.empty())
    throw InputError("--foreign", "is about states beside a scene, expected it with --scene");
  if (!arguments.tolerance.empty() && !arguments.bars)
    throw InputError("--tolerance", "is the tolerance of the error bars, expected it with --bars");
  for (const auto& [given, key] :
       {std::pair(arguments.noise.force, "--noise"), std::pair(arguments.noise.position, "--position-noise")})
    if (given && !arguments.bars)
      throw InputError(key, "is the noise of the error bars, expected it with --bars");
  if (arguments.bars && (run || !arguments.input.diff.empty()))
    throw InputError("--bars", "is for one set of states, expected it without --diff or a run");
  if (!arguments.places.through.empty() && extension != ".svg" && extension != ".png" && extension != ".pdf")
    throw InputError("--through",
                     "places the slices of a picture, expected it with -o OUT.svg, OUT.png or OUT.pdf");
  const bool points =
      !arguments.places.points.empty() || !arguments.places.line.empty() || arguments.places.grid;
  if (points && (run || !arguments.input.diff.empty()))
    throw InputError(
        "classify",
        "labels positions of one set of states, expected --points, --line or --grid without --diff or a run");
  if (run && arguments.space.index != "delaunay")
    throw InputError("--index", "octree is for a set of states, expected delaunay for a run");
}

void check_arguments(const Globals& globals, const ClassifyArguments& arguments) {
  if (arguments.input.diff.empty() == arguments.input.states.empty())
    throw InputError("classify", "expected either STATES (or a RUN/ folder) or --diff A B");
  if (arguments.space.spacing &&
      !(*arguments.space.spacing > 0 && *arguments.space.spacing <= largest_spacing))
    throw InputError(
        "--spacing",
        fmt::format("is not a length that states can have, expected metres in (0, {:.0e}]", largest_spacing));
  check_effect(globals, arguments, arguments.input.diff.empty() && fs::is_directory(arguments.input.states));
  if (arguments.places.grid && !(*arguments.places.grid > 0 && std::isfinite(*arguments.places.grid)))
    throw InputError("--grid", "is not a length, expected metres > 0");
  if (int(!arguments.places.points.empty()) + int(!arguments.places.line.empty()) +
          int(arguments.places.grid.has_value()) >
      1)
    throw InputError("classify", "expected one of --points, --line and --grid");
  if (arguments.agreement && (!arguments.input.diff.empty() || fs::is_directory(arguments.input.states)))
    throw InputError("--agreement", "is for one set of states, expected it without --diff or a run");
  if (arguments.output.empty()) return;
  const std::string extension = fs::path(arguments.output).extension();
  const bool series = !arguments.input.states.empty() && fs::is_directory(arguments.input.states);
  const std::vector<std::string> known =
      series                          ? std::vector<std::string>{".pvd"}
      : !arguments.input.diff.empty() ? std::vector<std::string>{".csv", ".vtu"}
                                      : std::vector<std::string>{".vtu", ".csv", ".svg", ".png", ".pdf"};
  if (std::ranges::find(known, extension) == known.end())
    throw InputError(arguments.output,
                     fmt::format("has the ending '{}', expected {}", extension, fmt::join(known, ", ")));
  check_writable(arguments.output, {arguments.input.states});
  for (const std::string& states : arguments.input.diff) check_writable(arguments.output, {states});
}

std::string at_most_90(const std::string& text) {
  return std::strtod(text.c_str(), nullptr) <= 90 ? "" : fmt::format("is {}, expected at most 90", text);
}

int run_classify(const Globals& globals, const ClassifyArguments& arguments) {
  use_palette(arguments.palette);
  if (!arguments.input.calibrate.empty()) {
    if (arguments.input.foreign && arguments.input.states.empty())
      throw InputError("--foreign", "takes states of another body, expected STATES with it");
    if (!arguments.input.diff.empty() || !arguments.places.points.empty() || !arguments.places.line.empty() ||
        arguments.places.grid)
      throw InputError("--calibrate", "goes with STATES, --foreign, --set, --seed and -o DIR/ alone");
    return calibrate_labels(globals, {.scene = arguments.input.calibrate,
                                      .states = arguments.input.states,
                                      .foreign = arguments.input.foreign,
                                      .output = arguments.output});
  }
  check_arguments(globals, arguments);
  if (!arguments.input.diff.empty()) return classify_diff(globals, arguments);
  if (fs::is_directory(arguments.input.states)) return classify_run(globals, arguments);
  const auto start = std::chrono::steady_clock::now();
  Progress progress(globals, "classify");
  progress.show("reading " + arguments.input.states);
  StatesInFrame loaded = load_set(arguments.input.states);
  if (has_sites(loaded)) return classify_sites(globals, arguments, loaded);
  std::vector<Vec3> points;
  if (!arguments.places.points.empty()) points = read_points_csv(arguments.places.points);
  if (!arguments.places.line.empty()) points = parse_line(arguments.places.line);
  progress.show("spacing and box");
  const Classified set = classify_states(globals, arguments, arguments.input.states, std::move(loaded));
  if (arguments.space.spacing)
    if (const auto line = spacing_beyond("--spacing", set.spacing, set.box, "the states"))
      warn(globals, *line);
  if (arguments.places.grid) points = grid_points(set, *arguments.places.grid);
  if (!arguments.places.through.empty() &&
      !set.box.contains(set.turn * parse_vector(arguments.places.through, "--through")))
    throw InputError("--through", fmt::format("'{}' lies outside the box, expected a place in it",
                                              arguments.places.through));
  const std::vector<Coverage> found = cover(set, points, progress);
  std::optional<HullSpacing> hull;
  progress.show("spacing of the hull");
  if (set.estimated_dimension == 3 && set.beside.empty())
    hull = hull_spacing(set.places(), set.box, arguments.space.coverage);
  const double seconds = seconds_since(start);
  std::optional<ErrorKnown> errors;
  if (wants_errors(arguments, set)) errors = error_known(globals, arguments, set, points);
  progress.show("writing " + arguments.output);
  if (!arguments.output.empty()) write_output(set, arguments, points, found, errors, globals);
  std::optional<Agreement> agreement;
  if (arguments.agreement) agreement = agreement_of(set, arguments);
  print_classified(globals, arguments, {set, points, found, agreement, errors, hull, seconds});
  return 0;
}

void add_thresholds(Command& sub, CoverageOptions& limits) {
  const auto threshold = [&](const char* option, double& value, const char* text) {
    sub.option(option, value, text).check(above_zero).group("Thresholds");
  };
  // An empty cone wider than 90 degrees means that all states lie on one side, so the point is not enclosed.
  const auto angle = [&](const char* option, double& value, const char* text) {
    sub.option(option, value, text).check(above_zero).check(at_most_90).group("Thresholds");
  };
  threshold("--safe-spread", limits.safe_spread, "Safe: spread at most this many h");
  threshold("--safe-cone-radius", limits.safe_cone_radius, "Safe: enclosed by states within this many h");
  angle("--safe-angle", limits.safe_angle_deg, "Safe: largest empty cone below this half-angle [deg]");
  threshold("--sparse-distance", limits.sparse_distance, "Sparse: a state within this many h");
  threshold("--gap-cone-radius", limits.gap_cone_radius, "Gap: states on both sides within this many h");
  angle("--gap-angle", limits.gap_angle_deg, "Gap: largest empty cone at most this half-angle [deg]");
}

}  // namespace

DeclaredTable coverage_output() {
  return {"coverage.csv", "What classify writes with --points or --line and -o.",
          declared<PointRow>(point_columns(true))};
}

void add_classify(CommandLine& line) {
  const auto arguments = std::make_shared<ClassifyArguments>();
  arguments->palette = usual_palette;
  Command sub =
      line.add("classify",
               "Show where the force is known from states: safe (densely), sparse, gap (a bridge between "
               "known regions), blank");
  sub.runs([arguments](const Globals& globals) { return run_classify(globals, *arguments); });
  sub.option("STATES", arguments->input.states,
             ".states file, CSV, the folder of a run, or setup:gap (full, sparse, blank)")
      .shows("STATES|RUN/");
  sub.option("--index", arguments->space.index, "delaunay (exact) or octree (by counting)")
      .one_of({"delaunay", "octree"});
  sub.option("--spacing", arguments->space.spacing,
             "Spacing h that counts as fully populated [m]; default: the file's")
      .shows("H");
  sub.option("--box", arguments->space.box, "Box [m]; default: the scene's, else that of the states")
      .shows("X0,Y0,Z0:X1,Y1,Z1");
  sub.option("--points", arguments->places.points,
             "Label these positions (CSV x,y,z; of states with sites sx,sy,sz,x,y,z)")
      .shows("Q.csv");
  sub.option("--line", arguments->places.line, "Label N positions along a line").shows("X,Y,Z:X,Y,Z:N");
  sub.option("--grid", arguments->places.grid, "Label a grid of this step over the box [m]").shows("H");
  sub.option("-o,--output", arguments->output,
             ".vtu .csv .svg .png .pdf; .pvd for a run, .vtu or .csv with --diff")
      .shows("OUT");
  sub.option("--diff", arguments->input.diff, "Compare two sets of states: changes from A to B")
      .takes(2)
      .shows("A B");
  sub.flag("--agreement", arguments->agreement, "Compare both indexes by volume");
  sub.option("--scene", arguments->input.scene,
             "Scene: spacing, box and the outline of the body; of states with sites the one with "
             "contact.anywhere")
      .shows("SCENE");
  sub.flag("--foreign", arguments->input.foreign, foreign_help);
  sub.flag(
      "--bars", arguments->bars,
      "Error bars of the points and the share of the box known within a tolerance, from known forces left "
      "out in groups");
  sub.option(
         "--tolerance", arguments->tolerance,
         "With --bars: error that counts as known, a share of the force or newtons; default: the scene's, "
         "else 0.07")
      .shows("0.07|\"0.07 N\"");
  sub.option("--noise", arguments->noise.force,
             "With --bars: deviation of one component of a measured force [N]. Default: estimated from the "
             "states")
      .shows("NEWTON")
      .check(zero_or_more);
  sub.option("--position-noise", arguments->noise.position,
             "With --bars: deviation of one coordinate of a measured position [m]")
      .shows("METRE")
      .check(zero_or_more);
  sub.flag("--list", arguments->places.list, "Print every point; default: if they are at most 20");
  sub.option("--through", arguments->places.through,
             "Point that the slices share; default: rest, or the middle")
      .shows("X,Y,Z");
  sub.option("--known", arguments->input.known, "States known before a run began").shows("STATES");
  sub.option("--calibrate", arguments->input.calibrate,
             "Scene: measure the error of each label by tight solves, or, with --foreign, by leaving out a "
             "part of the states; -o is a folder, STATES default to the lattice of the scene")
      .shows("SCENE");
  sub.option("--snapshots", arguments->places.snapshots, "Number of times in the series of a run; default 40")
      .between(1, 10000);
  add_thresholds(sub, arguments->space.coverage);
  add_palette(sub, arguments->palette);
}

}  // namespace forefeel
