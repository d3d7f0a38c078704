// Sustained HIP speed against workers: the highest speed at which 95 % of the frames that visit a cell of 6 mm for the
// first time are within 7 % of the reference, from an empty start, on lines all over the box and a little beyond,
// layer by layer. From the paper's predecessor (nearest states first, polynomials on the lattice, at the spacings
// that suit them) through the seed paper to the default, one change at a time: the cells of a study, so that a run that was
// cut goes on where it was.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/laboratory/reproduce.hpp"
#include "apps/laboratory/speed_bound.hpp"
#include "apps/picture/plot.hpp"
#include "apps/study/study_run.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/record/run_files.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

// name, what it changes; the first rows differ in the lattice alone.
struct Step {
  std::string name, changes;
};

std::vector<Step> steps() {
  std::vector<Step> all;
  const std::string predecessor =
      "policy = \"nearest\"\nselect = \"nearest\"\nswitch = \"none\"\n\"session.preempt\" = "
      "false\n\"session.rest_first\" = false\n"
      "\"session.first_guess\" = false\n"
      "\"model.kernel\" = \"cubic\"\n\"model.data\" = \"force\"\n\"model.neighbours\" = 100\n";
  const auto before = [&](const std::string& method, int mm) {
    all.push_back({fmt::format("predecessor, {} {} mm", method, mm),
                   fmt::format("{}\"session.method\" = \"{}\"\n\"state_space.spacing\" = {}\n",
                               all.empty() ? predecessor : "", method, 0.001 * mm)});
  };
  before("trilinear", 12);  // at 6 mm slower, at 18 mm never within 7 %
  before("tricubic", 12);
  before("tricubic", 18);  // at 24 mm never within 7 %
  all.push_back({"seed paper on its best lattice: r3 n=100, 12 mm",
                 "\"session.method\" = \"rbf\"\n\"state_space.spacing\" = 0.012\nswitch = \"paper\"\n"});
  all.push_back({"seed paper: r3 n=100, 6 mm", "\"state_space.spacing\" = 0.006\n"});
  all.push_back({"+ smooth switch", "switch = \"smooth\"\n"});
  all.push_back({"+ neighbours by label", "select = \"label\"\n"});
  all.push_back(
      {"+ stiffness data, r5 n=25",
       "\"model.kernel\" = \"quintic\"\n\"model.data\" = \"force+stiffness\"\n\"model.neighbours\" = 25\n"});
  all.push_back({"+ policy coverage", "policy = \"coverage\"\n"});
  all.push_back({"+ preemption", "\"session.preempt\" = true\n"});
  all.push_back({"+ rest first", "\"session.rest_first\" = true\n"});
  all.push_back({"+ first guess (default)", "\"session.first_guess\" = true\n"});
  all.push_back({"default, constant-velocity prediction", "\"session.predictor\" = \"constant-velocity\"\n"});
  all.push_back({"default, adaptive placement",
                 "\"session.predictor\" = \"kalman\"\n\"session.placement\" = \"adaptive\"\n"});
  all.push_back({"default, motion known (clairvoyant)",
                 "\"session.placement\" = \"lattice\"\npolicy = \"clairvoyant-greedy\"\n"});
  all.push_back({"default without the damped switch", "policy = \"coverage\"\nswitch = \"none\"\n"});
  all.push_back(
      {"default, rest known before the start", "switch = \"smooth\"\n\"session.rest_known\" = true\n"});
  // The others with our start too: the guess, and rest, which is the nearest state to them anyway, at the cost of a
  // factorisation.
  all.push_back({"seed paper, 6 mm + our start",
                 "\"session.rest_known\" = false\npolicy = \"nearest\"\nselect = \"nearest\"\nswitch = "
                 "\"paper\"\n\"session.preempt\" = false\n"
                 "\"model.kernel\" = \"cubic\"\n\"model.data\" = \"force\"\n\"model.neighbours\" = 100\n"});
  all.push_back({"seed paper, 12 mm + our start", "\"state_space.spacing\" = 0.012\n"});
  all.push_back(
      {"predecessor, tricubic 12 mm + our start", "\"session.method\" = \"tricubic\"\nswitch = \"none\"\n"});
  all.push_back({"predecessor, tricubic 18 mm + our start", "\"state_space.spacing\" = 0.018\n"});
  return all;
}

constexpr std::size_t predecessors = 3, seed_best = 3, seed_paper = 4, ours_row = 11, known_row = 16,
                      seed_rest = 17, seed_best_rest = 18, predecessor_rest = 19;  // the last: two rows
constexpr std::size_t drawn[] = {3, 4, 7, 10, 11, 14, 15, 16};  // besides the best predecessor

constexpr const char* bound_row = "bound: exact force once rest can be known, the first guess before";
constexpr const char* bound_row_without = "bound: exact force once rest can be known, nothing before";

constexpr const char* built_in_file = "scene.toml";  // where the study finds the built-in scene
constexpr const char* study_file = "speed.toml";

// What --set gives is not given by the study as well.
bool is_set(const Globals& globals, const std::string& key) {
  return std::ranges::any_of(globals.set,
                             [&](const std::string& text) { return text.starts_with(key + "="); });
}

std::string study_text(const Laboratory& laboratory, const ReproduceOptions& runs) {
  const std::string scene =
      laboratory.built_in() ? built_in_file : fs::absolute(laboratory.scene().file).string();
  std::string escaped;
  for (const char c : scene) escaped += c == '\\' || c == '"' ? std::string{'\\', c} : std::string(1, c);
  std::string seeds = "1";
  for (int seed = 2; seed <= runs.seeds; ++seed) seeds += fmt::format(", {}", seed);
  std::string text = fmt::format("scene = \"{}\"\nseeds = [{}]\n\n[session]\n", escaped, seeds);
  if (!is_set(laboratory.globals(), "session.device")) text += "device = \"path:raster\"\n";
  if (!is_set(laboratory.globals(), "session.cost")) text += "cost = \"paper\"\n";
  if (!is_set(laboratory.globals(), "session.reference_step"))
    text += "reference_step = 0.5    # m; first visits are sampled anyway\n";
  text += "visit_cell = 0.006       # m\n";
  text +=
      fmt::format("\n[sustained]\ntravel = {}\nshare = 0.95\ntolerance = 0.07\nlow = 0.015625\nhigh = 2.0\n",
                  runs.travel);
  for (const Step& step : steps())
    text += fmt::format("\n[[step]]\nname = \"{}\"\n{}", step.name, step.changes);
  text += "\n[vary]\nworkers = [";
  return text + fmt::format("{}]\n", fmt::join(runs.workers, ", "));
}

using Speeds =
    std::vector<std::vector<double>>;  // [step][workers], geometric mean over the seeds; 0: below the least

Speeds speeds_of(const Study& study, const StudyPlan& plan, const StudyResult& result) {
  Speeds sums(study.axes[0].values.size(), std::vector<double>(study.axes[1].values.size(), 0.0));
  for (std::size_t i = 0; i < plan.cells.size(); ++i) {
    const double speed = result.cells[i].at("sustained.speed").get<double>();
    sums[plan.cells[i].choice[0]][plan.cells[i].choice[1]] += speed > 0 ? std::log(speed) : -INFINITY;
  }
  for (auto& row : sums)
    for (double& v : row) v = std::exp(v / static_cast<double>(study.seeds.size()));
  return sums;
}

// Of the predecessor's lattices the best for each number of workers.
std::vector<double> best_predecessor(const Speeds& speeds, const ReproduceOptions& runs) {
  std::vector<double> best(runs.workers.size(), 0.0);
  for (std::size_t s = 0; s < predecessors; ++s)
    for (std::size_t w = 0; w < best.size(); ++w) best[w] = std::max(best[w], speeds[s][w]);
  return best;
}

std::string shown(double speed) {
  return speed > 0 ? fmt::format("{:.3g}", 1e3 * speed) : "below 15.6";
}  // [mm/s]
std::string ratio(double a, double b) {
  return a > 0 && b > 0 ? fmt::format("×{:.3g}", a / b) : "–";
}

constexpr double wanted = 10, cap = 2.0;  // over the predecessor; [m/s]

// What the damped switch alone leaves, whoever schedules: geometric means over the seeds.
struct Bounds {
  double guessed = 1, without = 1;  // with the first guess and without it [m/s]
  double known = 0, settled = 0,
         settled_without = 0;  // means; the latter: how long the force fades in then [s]
};

Bounds bounds_of(const StudyPlan& plan, const Globals& globals) {
  Bounds all;
  double cells = 0;
  for (const StudyCell& cell : plan.cells) {
    if (cell.choice[0] != ours_row || cell.choice[1] != 0) continue;
    ReferenceService references(reference_options(session_input(plan.scenes[cell.scene])), globals.threads);
    const SpeedBound guessed = speed_bound(plan, cell, references, true),
                     without = speed_bound(plan, cell, references, false);
    all.guessed *= guessed.speed;
    all.without *= without.speed;
    all.known += guessed.known;
    all.settled += guessed.settled_after;
    all.settled_without += without.settled_after;
    ++cells;
  }
  for (double* speed : {&all.guessed, &all.without}) *speed = std::pow(*speed, 1 / cells);
  for (double* time : {&all.known, &all.settled, &all.settled_without}) *time /= cells;
  return all;
}

// Whether ten times the predecessor can be reached by anybody at all.
std::string out_of_reach(double before, const Bounds& bounds) {
  const double goal = wanted * before;
  if (goal > cap) return fmt::format("{} is above the {} that are tried", shown(goal), shown(cap));
  if (goal > bounds.guessed)
    return fmt::format("{} is above the {} that exact models from the first moment on sustain", shown(goal),
                       shown(bounds.guessed));
  return fmt::format("{} is within the {} that exact models sustain", shown(goal), shown(bounds.guessed));
}

std::string bounds_text(const Bounds& bounds, const Speeds& speeds, const std::vector<double>& before,
                        const ReproduceOptions& runs) {
  std::string text = fmt::format(
      "The last two rows know the exact force everywhere from the first moment on at which rest can have "
      "been solved, {:.3f} s. "
      "Nothing but what comes before and its fade-out is lost then, {:.3f} s more after the first guess, "
      "{:.3f} s after no force at "
      "all: force and rule of the switch decide how long it takes, not policy, prediction, placement or "
      "number of workers. They "
      "sustain {} and {} mm/s. Ten times the predecessor's speed: ",
      bounds.known, bounds.settled, bounds.settled_without, shown(bounds.guessed), shown(bounds.without));
  for (std::size_t w = 0; w < runs.workers.size(); ++w)
    text += fmt::format("{}with {} workers {}", w > 0 ? "; " : "", runs.workers[w],
                        out_of_reach(before[w], bounds));
  text += ". What is above is out of the reach of any scheduler whose models are right, under this switch. ";
  const double best = *std::ranges::max_element(speeds[ours_row]);
  if (best > bounds.guessed)
    text += fmt::format(
        "Only a wrong model can be a little faster: one nearer to the guess than the body is leaves less to "
        "fade out ({} at "
        "best). ",
        shown(best));
  return text;
}

Picture picture_of(const std::vector<std::pair<std::string, std::vector<double>>>& curves,
                   const ReproduceOptions& runs) {
  std::string blocks, plot = "plot ";
  for (std::size_t i = 0; i < curves.size(); ++i) {
    std::string lines;
    for (std::size_t w = 0; w < runs.workers.size(); ++w)
      if (curves[i].second[w] > 0)
        lines += fmt::format("{} {}\n", runs.workers[w], 1e3 * curves[i].second[w]);
    if (lines.empty()) lines = "1 NaN\n";
    blocks += data_block(fmt::format("curve{}", i), lines);
    plot += fmt::format("{}$curve{} using 1:2 with linespoints lw 2 pt 7 ps 0.6 lc rgb \"{}\" title \"{}\"",
                        i ? ", " : "", i, line_colour(i), curves[i].first);
  }
  return {
      .name = "speed",
      .caption = "Sustained HIP speed against workers, from an empty start.",
      .script = std::string(plot_style) + blocks +
                "set logscale xy\nset xlabel \"workers\"\nset ylabel \"sustained speed [mm/s]\"\n"
                "set xtics (2, 4, 8, 16, 32, 64)\nset xrange [1.7:75]\nset key outside right noenhanced\n" +
                plot + "\n"};
}

void write_csv(const fs::path& folder, const Speeds& speeds, const std::vector<double>& before,
               const Bounds& bounds, const ReproduceOptions& runs) {
  std::string csv = "step,workers,speed,to_predecessor,to_seed_paper\n";
  const auto line = [&](const std::string& name, std::size_t w, double v) {
    const auto over = [&](double b) { return b > 0 ? fmt::format("{:.4g}", v / b) : std::string(); };
    csv += fmt::format("\"{}\",{},{:.6g},{},{}\n", name, runs.workers[w], v, over(before[w]),
                       over(speeds[seed_paper][w]));
  };
  const std::vector<Step> all = steps();
  for (std::size_t s = 0; s < all.size(); ++s)
    for (std::size_t w = 0; w < runs.workers.size(); ++w) line(all[s].name, w, speeds[s][w]);
  for (std::size_t w = 0; w < runs.workers.size(); ++w) line(bound_row, w, bounds.guessed);
  for (std::size_t w = 0; w < runs.workers.size(); ++w) line(bound_row_without, w, bounds.without);
  write_text(folder / "speed.csv", csv);
}

// Ours against the others when they begin as ours does.
nlohmann::ordered_json start_json(const Speeds& speeds, const std::vector<double>& before, std::size_t w) {
  const double ours = speeds[ours_row][w], best = std::max(speeds[seed_rest][w], speeds[seed_best_rest][w]);
  const double predecessor =
      std::max({before[w], speeds[predecessor_rest][w], speeds[predecessor_rest + 1][w]});
  const auto to = [&](double other) { return number(other > 0 ? ours / other : unknown); };
  return {{"predecessor", predecessor},
          {"seed_paper", speeds[seed_rest][w]},
          {"seed_paper_best", best},
          {"to_predecessor", to(predecessor)},
          {"to_seed_paper", to(speeds[seed_rest][w])},
          {"to_seed_paper_best", to(best)}};
}

nlohmann::ordered_json summary_of(const Speeds& speeds, const std::vector<double>& before,
                                  const Bounds& bounds, const ReproduceOptions& runs) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (std::size_t w = 0; w < runs.workers.size(); ++w) {
    const double ours = speeds[ours_row][w], paper = speeds[seed_paper][w];
    const double best = std::max(paper, speeds[seed_best][w]);
    rows.push_back({{"workers", runs.workers[w]},
                    {"speed", ours},
                    {"predecessor", before[w]},
                    {"seed_paper", paper},
                    {"to_predecessor", number(before[w] > 0 ? ours / before[w] : unknown)},
                    {"to_seed_paper", number(paper > 0 ? ours / paper : unknown)},
                    {"to_seed_paper_best", number(best > 0 ? ours / best : unknown)},
                    {"capped", ours >= cap},
                    {"our_start_for_all", start_json(speeds, before, w)},
                    {"rest_known_before", speeds[known_row][w]},
                    {"ten_times_in_reach", wanted * before[w] <= std::min(cap, bounds.guessed)}});
  }
  const nlohmann::ordered_json bound{{"speed", bounds.guessed},
                                     {"known", bounds.known},
                                     {"settled_after", number(bounds.settled)},
                                     {"speed_without_guess", bounds.without},
                                     {"settled_after_without_guess", number(bounds.settled_without)}};
  return {{"travel", runs.travel}, {"seeds", runs.seeds}, {"rows", rows}, {"bound", bound}};
}

std::string plain(const std::string& key) {  // of session.policy, policy, "session.policy" alike
  const std::string bare = key.starts_with('"') ? key.substr(1, key.size() - 2) : key;
  return bare.starts_with("session.") ? bare.substr(8) : bare;
}

}  // namespace

void check_speed_overrides(const Globals& globals) {
  for (const std::string& text : globals.set) {
    const std::string key = text.substr(0, text.find('='));
    for (const char* own : {"workers", "seconds", "clock", "seed"})
      if (plain(key) == own)
        throw InputError({.option = "--set", .key = key},
                         "is what `speed` sets itself, expected another key");
    for (const Step& step : steps())
      for (std::size_t from = 0, end; (end = step.changes.find('\n', from)) != std::string::npos;
           from = end + 1)
        if (plain(step.changes.substr(from, step.changes.find(" = ", from) - from)) == plain(key))
          throw InputError(
              "--set " + key,
              fmt::format("is what `speed` compares (step '{}' changes it), expected another key",
                          step.name));
  }
}

namespace {

// The study, in files of the folder, so that it can be run again by itself.
StudyPlan plan_speed(const Laboratory& laboratory, const ReproduceOptions& runs, const fs::path& folder) {
  if (laboratory.built_in()) write_text(folder / built_in_file, std::string(built_in_scene_text()));
  write_text(folder / study_file, study_text(laboratory, runs));
  return plan_study(read_study(folder / study_file, laboratory.globals().set));
}

// A folder, made where it is not there; what is written there since is taken back unless it is kept.
class Trial {
 public:
  explicit Trial(const fs::path& folder) : folder_(folder) {
    fs::path made = fs::absolute(folder).lexically_normal();
    if (!made.has_filename()) made = made.parent_path();  // out/
    for (; !made.empty() && !fs::exists(made); made = made.parent_path()) made_.push_back(made);
    for (const char* name : {built_in_file, study_file})
      if (std::ifstream in(folder / name, std::ios::binary); in)
        before_.emplace_back(name, std::string(std::istreambuf_iterator<char>(in), {}));
    prepare_run_folder(folder);
  }
  void take_back() {
    std::error_code error;
    for (const char* name : {built_in_file, study_file}) fs::remove(folder_ / name, error);
    for (const auto& [name, text] : before_) write_text(folder_ / name, text);
    for (const fs::path& made : made_) fs::remove(made, error);  // if it is empty
  }

 private:
  fs::path folder_;
  std::vector<fs::path> made_;  // the innermost first
  std::vector<std::pair<std::string, std::string>> before_;
};

}  // namespace

void check_speed(const Laboratory& laboratory, const ReproduceOptions& runs, const fs::path& folder) {
  Trial trial(folder);
  try {
    plan_speed(laboratory, runs, folder);
  } catch (const InputError& error) {
    trial.take_back();
    // The study is gone then: "out/speed.toml:7: session.device" is no place to look at.
    for (const char* name : {built_in_file, study_file}) {
      const InputPlace& place = error.place();
      if (place.file != (folder / name).string()) continue;
      throw InputError("reproduce speed",
                       place.key.empty() ? error.problem() : place.key + ": " + error.problem());
    }
    throw;
  } catch (...) {
    trial.take_back();
    throw;
  }
}

Findings reproduce_speed(Laboratory& laboratory, const ReproduceOptions& runs, const fs::path& folder,
                         const ShowShare&) {
  const StudyPlan plan = plan_speed(laboratory, runs, folder);
  const StudyResult result = run_study(plan, folder / "speed", laboratory.globals());
  if (result.interrupted)
    return {.summary = {{"interrupted", true}},
            .html = {},
            .lines = {},
            .unmet = {"interrupted; the same command goes on from here"}};
  const Speeds speeds = speeds_of(plan.study, plan, result);
  const std::vector<double> before = best_predecessor(speeds, runs);
  const Bounds bounds = bounds_of(plan, laboratory.globals());
  write_csv(folder, speeds, before, bounds, runs);

  Findings found{.summary = summary_of(speeds, before, bounds, runs), .html = {}, .lines = {}};
  std::vector<std::vector<std::string>> table{{"sustained speed, mm/s"}};
  for (const int workers : runs.workers) table[0].push_back(fmt::format("{} workers", workers));
  const std::vector<Step> all = steps();
  std::vector<std::pair<std::string, std::vector<double>>> curves{{"predecessor, best lattice", before}};
  for (std::size_t s = 0; s < all.size(); ++s) {
    table.push_back({all[s].name});
    for (std::size_t w = 0; w < runs.workers.size(); ++w)
      table.back().push_back(fmt::format("{} ({})", shown(speeds[s][w]), ratio(speeds[s][w], before[w])));
    if (std::ranges::count(drawn, s) > 0) curves.emplace_back(all[s].name, speeds[s]);
  }
  for (const auto& [name, speed] :
       {std::pair{bound_row, bounds.guessed}, std::pair{bound_row_without, bounds.without}}) {
    table.push_back({name});
    for (const double other : before)
      table.back().push_back(fmt::format("{} ({})", shown(speed), ratio(speed, other)));
  }
  curves.emplace_back(bound_row, std::vector<double>(runs.workers.size(), bounds.guessed));
  for (std::size_t w = 0; w < runs.workers.size(); ++w)
    found.lines.push_back(fmt::format(
        "{} workers: {} mm/s; predecessor at its best {}, {}; seed paper {}, {} (on its best lattice {})",
        runs.workers[w], shown(speeds[ours_row][w]), shown(before[w]), ratio(speeds[ours_row][w], before[w]),
        shown(speeds[seed_paper][w]), ratio(speeds[ours_row][w], speeds[seed_paper][w]),
        ratio(speeds[ours_row][w], std::max(speeds[seed_paper][w], speeds[seed_best][w]))));
  for (std::size_t w = 0; w < runs.workers.size(); ++w) {
    const double seed = speeds[seed_rest][w], seed_12 = speeds[seed_best_rest][w];
    const double predecessor = std::max(speeds[predecessor_rest][w], speeds[predecessor_rest + 1][w]);
    found.lines.push_back(fmt::format(
        "{} workers, the others with our start too: predecessor {}, {}; seed paper {}, {} (on 12 mm {}, {}); "
        "ours with rest known before the start: {}",
        runs.workers[w], shown(predecessor), ratio(speeds[ours_row][w], predecessor), shown(seed),
        ratio(speeds[ours_row][w], seed), shown(seed_12), ratio(speeds[ours_row][w], seed_12),
        shown(speeds[known_row][w])));
  }
  found.lines.push_back(bounds_text(bounds, speeds, before, runs));
  found.html =
      paragraph("Sustained speed",
                "The highest speed at which 95 % of the frames that visit a cell of 6 mm for the first time "
                "are within 7 % of "
                "the reference. Each run starts empty and goes its way along lines that cross the box, layer "
                "by layer; speeds up to "
                "2 m/s are tried. In brackets: over the predecessor (nearest states first, polynomials on "
                "the lattice) at the "
                "spacing and degree that suit it best for that number of workers, which has no damped "
                "switch. Where nothing is known there is no "
                "force, and the first model fades in from zero at the rate of the switch. A run at v over L "
                "has 0.05 L / v before 5 % of its "
                "visits are lost: the first solve, its fade-in and whatever else the first force lacks must "
                "fit into it, 0.25 m over v at "
                "L = 5 m. Ours begins with the state at rest, which is known to be in equilibrium: no "
                "iteration, one factorisation for its "
                "stiffness, charged as one of the four iterations that a state takes on average; and until "
                "that is there the hand feels "
                "the stiffness of a disc of the patch's area on a half-space of the body's material, a "
                "formula that is some tens of per cent "
                "off, from which the true one fades in much sooner than from nothing. The rows before, the "
                "predecessor and the "
                "seed paper have neither; the last rows are theirs with the same start. With rest known "
                "before the start nothing fades in at all; the row without the switch shows what the fade-in "
                "costs, the one before it what knowing the motion would add. With few "
                "workers the share within 7 % stays close to 95 % over a wide range of speeds, so that one "
                "or two frames decide where a "
                "single seed ends: `--seeds` takes the geometric mean of several.");
  found.html += html_table(table) + draw_into(folder, picture_of(curves, runs));
  for (const std::string& line : found.lines) found.html += paragraph("Found", line);
  return found;
}

}  // namespace forefeel
