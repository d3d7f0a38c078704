// forefeel-bench truth [SCENE] [-o DIR]: the whole error of a force, mesh and contact included, against what a state
// costs. The truth is a solved body of quadratic elements, twice as many as the fine body has, small at the pad.
// Positions are drawn in a ball about rest. Every position counts: a solve that fails is an error of 100 %.
//   error          |f - f_truth| / max(|f_truth|, session.error_floor)
//   ms_per_state   processor time of the 27 states of a lattice of 12 mm about rest over those solved, one thread
//   once_s         processor time of what is done once, nothing kept from before: meshing, and the rest jets of the
//                  fine body

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/bench/bench.hpp"
#include "apps/bench/bench_row.hpp"
#include "apps/console/console.hpp"
#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"
#include "apps/picture/scratch_folder.hpp"
#include "apps/scene/scene.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/meshing/phantom.hpp"
#include "scheduling/motion/random.hpp"
#include "solver/body/fine_jet.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/lattice/generate.hpp"
#include "solver/system/discretisation.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr double farthest = 0.024, nearest = 0.004;  // positions from rest [m]
constexpr std::size_t positions = 10;
constexpr std::size_t fine_elements = 3'500, true_elements = 7'000;
constexpr double lattice_spacing = 0.012;  // [m]

struct Variant {
  Element element = Element::linear;
  std::size_t elements = 0;
  bool graded = false, fine = false;
};

std::vector<Variant> variants() {
  std::vector<Variant> all;
  for (const auto& [element, counts] :
       {std::pair(Element::linear, std::array<std::size_t, 2>{1'800, 7'000}),
        std::pair(Element::quadratic, std::array<std::size_t, 2>{900, 1'800})})
    for (const std::size_t count : counts)
      for (const bool graded : {false, true})
        for (const bool fine : {false, true}) all.push_back({element, count, graded, fine});
  return all;
}

struct TruthRow {
  Variant variant;
  std::size_t elements = 0, unknowns = 0;
  std::string fine_body;  // empty: none
  std::vector<double> errors;
  double ms_per_state = unknown, once_s = unknown;
  std::size_t failed = 0;
};

const JsonKeys<TruthRow>& truth_keys() {
  using R = TruthRow;
  static const JsonKeys<R> keys{
      {"element", "", "bench truth: linear or quadratic", [](const R& r) { return name(r.variant.element); }},
      {"graded", "", "true: elements are small at the pad; false: of one size",
       [](const R& r) { return r.variant.graded; }},
      {"unknowns", "", "of the body", &R::unknowns},
      {"fine", "", "the fine body that corrects the forces; null: none",
       [](const R& r) { return r.fine_body.empty() ? Json() : Json(r.fine_body); }},
      {"ms_per_state", "ms",
       "processor time of the 27 states of a lattice of 12 mm over those solved, one thread",
       &R::ms_per_state},
      {"once_s", "s", "processor time of meshing and of the fine body's jets, nothing kept from before",
       &R::once_s},
      {"failed", "", "solves that failed; each counts as an error of 100 %", &R::failed}};
  return keys;
}

// The cache folder is an empty one of its own while this lives, so that nothing kept makes work look cheap.
class NothingKept {
 public:
  NothingKept() {
    const char* const given = std::getenv("XDG_CACHE_HOME");
    if (given) before_ = given;
    if (folder_.path().empty())
      throw InputError("truth", "found no room for its temporary files, expected a folder to write to");
    setenv("XDG_CACHE_HOME", folder_.path().c_str(), 1);
  }
  ~NothingKept() { before_ ? setenv("XDG_CACHE_HOME", before_->c_str(), 1) : unsetenv("XDG_CACHE_HOME"); }
  NothingKept(const NothingKept&) = delete;
  NothingKept& operator=(const NothingKept&) = delete;

 private:
  std::optional<std::string> before_;
  ScratchFolder folder_;
};

// Processor time, which other programs on the machine do not lengthen [s].
double processor_seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// A body of the bench: a phantom, or the scene that was given.
struct Subject {
  std::string name, file;  // file: of a given scene, else empty
};

Scene scene_of(const Globals& globals, const Subject& subject, const Variant& variant) {
  std::vector<std::string> set = globals.set;
  if (subject.file.empty())
    set.insert(set.begin(), {"body.phantom=" + subject.name, "contact={ pad = 1000.0, radius = 0.02 }"});
  set.push_back(fmt::format("body.element={}", name(variant.element)));
  set.push_back(fmt::format("body.elements={}", variant.elements));
  set.push_back(fmt::format("body.uniform={}", !variant.graded));
  set.push_back(variant.fine ? fmt::format("body.fine={{ elements = {} }}", fine_elements)
                             : std::string("body.fine=false"));
  const SceneUse use{.spacing = false, .quiet = true};
  return subject.file.empty() ? scene_of_text(built_in_scene_text(), subject.name, set, use)
                              : load_scene(subject.file, set, nullptr, use);
}

// The same for all variants of a body; uniform in the ball.
std::vector<Vec3> drawn(std::uint64_t seed) {
  std::vector<Vec3> at;
  for (std::uint64_t i = 0; at.size() < positions; ++i) {
    Vec3 x;
    for (int axis = 0; axis < 3; ++axis) {
      const double share =
          static_cast<double>(random::mix(seed + 17, 3 * i + static_cast<std::uint64_t>(axis)) >> 11) *
          0x1p-53;
      x[axis] = farthest * (2 * share - 1);
    }
    if (x.norm() <= farthest && x.norm() >= nearest) at.push_back(x);
  }
  return at;
}

std::vector<State> solved(const std::shared_ptr<const Body>& body, const std::vector<Vec3>& at) {
  std::vector<State> states(at.size());
  SolverBasis basis(body);
  basis.discretisation();
#pragma omp parallel
  {
    Solver solver(basis);
#pragma omp for schedule(dynamic)
    for (std::size_t i = 0; i < at.size(); ++i) states[i] = solver.reference(at[i], 0.006).state;
  }
  return states;
}

TruthRow measured(const Globals& globals, const Subject& subject, const Variant& variant,
                  const std::vector<Vec3>& at, const std::vector<State>& truth) {
  TruthRow row;
  row.variant = variant;
  std::optional<Scene> scene;
  {
    const NothingKept empty;
    const double begun = processor_seconds(CLOCK_PROCESS_CPUTIME_ID);
    scene = scene_of(globals, subject, variant);
    row.once_s = processor_seconds(CLOCK_PROCESS_CPUTIME_ID) - begun;
  }
  const Body& body = *scene->body;
  row.elements = body.mesh.tets.size();
  row.unknowns = 3 * static_cast<std::size_t>(discretise(body).free_nodes);
  if (body.fine) row.fine_body = fmt::format("quadratic {}", fine_elements);
  LatticeOptions options;
  options.threads = 1;
  options.spacing = lattice_spacing;
  options.box = {Vec3::Constant(-lattice_spacing), Vec3::Constant(lattice_spacing)};
  const double begun = processor_seconds(CLOCK_PROCESS_CPUTIME_ID);
  const GenerateReport report = generate_lattice(scene->body, options, [](const State&) {});
  row.ms_per_state = 1e3 * (processor_seconds(CLOCK_PROCESS_CPUTIME_ID) - begun) /
                     static_cast<double>(std::max<std::size_t>(1, report.solved));
  const std::vector<State> states = solved(scene->body, at);
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!truth[i].usable()) continue;
    row.failed += !states[i].usable();
    const double scale = std::max(truth[i].force.norm(), scene->session.judging.error_floor);
    row.errors.push_back(states[i].usable() ? (states[i].force - truth[i].force).norm() / scale : 1);
  }
  return row;
}

Json json_of(const Subject& subject, const TruthRow& row) {
  const std::vector<double> error = p50_p95_max(row.errors);
  Json json = row_json({.name = fmt::format("{} {}", name(row.variant.element), row.elements),
                        .baseline = "a solved refined body",
                        .ours_us = 1e3 * row.ms_per_state,
                        .baseline_us = unknown,
                        .error = error,
                        .n = row.errors.size()},
                       {.scene = subject.name, .tolerance = 1e-10});
  json["elements"] = row.elements;
  add_to(json, truth_keys(), row);
  return json;
}

std::string line_of(const TruthRow& row) {
  const std::vector<double> error = p50_p95_max(row.errors);
  return fmt::format("  {:<9} {:>6} {:<7} {:<5} {:>8} {:>9.3g} {:>7.2f} {:>8.2g} {:>8.2g} {:>8.2g} {:>5}",
                     name(row.variant.element), row.elements, row.variant.graded ? "graded" : "uniform",
                     row.fine_body.empty() ? "" : "fine", row.unknowns, row.ms_per_state, row.once_s,
                     100 * error[0], 100 * error[1], 100 * error[2], row.failed);
}

// One panel a body: p95 against milliseconds, a symbol for each kind.
std::string panel(const Subject& subject, const std::vector<TruthRow>& rows, std::size_t number) {
  std::string blocks, curves;
  int kind = 0;
  for (const Element element : {Element::linear, Element::quadratic})
    for (const bool fine : {false, true}) {
      std::string points;
      for (const TruthRow& row : rows)
        if (row.variant.element == element && row.fine_body.empty() != fine)
          points += fmt::format("{} {} \"{}{}\"\n", row.ms_per_state,
                                std::max(1e-4, 100 * p50_p95_max(row.errors)[1]), row.elements,
                                row.variant.graded ? " graded" : "");
      const std::string block = fmt::format("truth_{}_{}", number, kind);
      blocks += data_block(block, points);
      const std::string colour = line_colour(element == Element::linear ? 0 : 1);
      curves += fmt::format(
          "{}${} using 1:2 with points pt {} ps 1 lc rgb '{}' title '{}{}', ${} using 1:2:3 "
          "with labels left offset 0.7,0 font ',8' notitle",
          kind ? ", " : "", block, fine ? 7 : 6, colour, name(element), fine ? " with a fine body" : "",
          block);
      ++kind;
    }
  return blocks + fmt::format("set title '{}' noenhanced\nplot {}\n", plain_text(subject.name), curves);
}

std::string picture(const std::vector<std::string>& panels) {
  std::string script =
      "set logscale xy\nset xlabel 'time of a state [ms]'\nset ylabel 'error of the force, p95 [%]'\nset "
      "grid\nset key top right font ',9' samplen 1\nset xrange [0.1:1000]\nset yrange [0.1:200]\n";
  script += panels.size() > 1 ? "set multiplot layout 2,2\n" : "set multiplot layout 1,1\n";
  for (const std::string& panel : panels) script += panel;
  return script + "unset multiplot\n";
}

}  // namespace

DeclaredTable declared_bench_truth() {
  return bench_table("truth", {below("rows[]", declared(truth_keys())), declared(instruction_set_keys())});
}

int bench_truth(const Globals& globals, const std::string& file, const std::string& folder) {
  std::vector<Subject> subjects;
  if (file.empty())
    for (const std::string& phantom : phantom_names()) subjects.push_back({phantom, ""});
  else
    subjects.push_back({file, file});
  scene_of(globals, subjects.front(),
           {Element::linear, 1'800, false, false});  // a bad one leaves no folder behind
  claim_bench_folder(folder, {"truth.svg"});
  Progress progress(globals, "bench truth");
  const std::vector<Variant> all = variants();
  Json document{{"rows", Json::array()}};
  std::vector<std::string> panels;
  for (std::size_t s = 0; s < subjects.size(); ++s) {
    const auto show = [&](double done, const std::string& what) {
      progress.show((static_cast<double>(s) + done) / static_cast<double>(subjects.size()),
                    subjects[s].name + ": " + what);
    };
    show(0, "the truth");
    const std::vector<Vec3> at = drawn(globals.seed);
    const std::vector<State> truth =
        solved(scene_of(globals, subjects[s], {Element::quadratic, true_elements, true, false}).body, at);
    std::vector<TruthRow> rows;
    for (std::size_t v = 0; v < all.size(); ++v) {
      show(0.5 + 0.5 * static_cast<double>(v) / static_cast<double>(all.size()), "variants");
      rows.push_back(measured(globals, subjects[s], all[v], at, truth));
      document["rows"].push_back(json_of(subjects[s], rows.back()));
    }
    std::string lines = fmt::format(
        "{}: {} of {} positions to {:g} mm have a truth\n  {:<9} {:>6} {:<7} {:<5} {:>8} {:>9} {:>7} {:>8} "
        "{:>8} "
        "{:>8} {:>5}\n",
        subjects[s].name, std::ranges::count_if(truth, &State::usable), at.size(), 1e3 * farthest, "element",
        "tets", "mesh", "", "unknowns", "ms/state", "once s", "p50 %", "p95 %", "max %", "fail");
    for (const TruthRow& row : rows) lines += line_of(row) + "\n";
    say(globals, lines);  // minutes before those of the next body
    panels.push_back(panel(subjects[s], rows, s));
  }
  const BenchEnd end{};
  for (const JsonKeys<BenchEnd>& keys : {instruction_set_keys(), provenance_keys()})
    add_to(document, keys, end);
  if (!folder.empty()) {
    const std::optional<std::string> svg =
        draw_svg("truth", 900, panels.size() > 1 ? 760 : 420, picture(panels));
    if (svg) write_whole(fs::path(folder) / "truth.svg", *svg);
  }
  if (globals.json) print_json(document);
  return 0;
}

}  // namespace forefeel
