// forefeel-bench scale [SCENE] [--full] [-o DIR]: how generate, classify and evaluate gain by threads and grow with
// size, beside CHOLMOD and SciPy on as many threads. Times are by the wall.
//   gain           t(1) / t(p) of one job on p threads
//   serial_share   s of t(p) = t(1) (s + (1 - s) / p), fitted to the threads of this run
//   work / path    of generate: what any number of threads could gain at most (generate.hpp)

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "apps/bench/bench.hpp"
#include "apps/bench/bench_one_state.hpp"
#include "apps/bench/bench_scale_parts.hpp"
#include "apps/bench/newton_baseline.hpp"
#include "apps/console/console.hpp"
#include "apps/console/provenance.hpp"
#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"
#include "apps/scene/scene.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/instruction_set.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

constexpr double same_force = 1e-8;  // largest difference from SciPy, over the largest force

// A body and its lattice: a small one, and the one of --full.
struct LatticeCase {
  std::string name;
  std::vector<std::string> set;
  double spacing, full_spacing;  // [m]
};

std::vector<LatticeCase> lattice_cases() {
  const std::string pad = "contact={ pad = 1000.0, radius = 0.02 }";
  return {{"pad", {pad, "body.fine=false"}, 0.012, 0.004},
          {"rigid", {}, 0.012, 0.004},
          {"pad, 8 thousand", {pad, "body.fine=false", "body.elements=8000"}, 0.024, 0.006}};
}

struct Sizes {
  std::vector<std::size_t> classified, evaluated;         // states; of evaluate as many points
  std::vector<std::pair<std::size_t, std::size_t>> many;  // states and points
};

Sizes sizes_of(bool full) {
  if (full) return {{10'000, 100'000, 1'000'000}, {1'000, 5'000}, {{50'000, 100'000}}};
  return {{10'000, 50'000}, {1'000, 5'000}, {}};
}

// 1, 2, 4, …, all.
std::vector<int> thread_counts(const Globals& globals) {
  const int most = globals.threads > 0 ? globals.threads : omp_get_max_threads();
  std::vector<int> counts;
  for (int p = 1; p < most; p *= 2) counts.push_back(p);
  counts.push_back(most);
  return counts;
}

double gain_of(const ScaleRow& row, double alone) {
  return alone / row.seconds();
}

const JsonKeys<ScaleRow>& scale_keys() {
  using R = ScaleRow;
  const auto of_parallel = [](double ParallelTimes::*time) {
    return [time](const R& r) { return r.parallel ? Json(*json_value((*r.parallel).*time)) : Json(); };
  };
  static const JsonKeys<R> keys{
      {"per_s", "1/s", "bench scale: states or points a second",
       [](const R& r) { return 1e6 / r.row.ours_us; }},
      {"seconds", "s", "of the job, by the wall", [](const R& r) { return r.seconds(); }},
      {"serial_share", "1",
       "s of t(p) = t(1) (s + (1 - s) / p), over the threads of this run; null: one number of threads",
       &R::serial},
      {"parallel.work_s", "s", "as of generate; null: another job", of_parallel(&ParallelTimes::work)},
      {"parallel.path_s", "s", "the same", of_parallel(&ParallelTimes::path)},
      {"parallel.idle_s", "s", "the same", of_parallel(&ParallelTimes::idle)}};
  return keys;
}

struct ScaleEnd {
  bool scipy = false;
};
const JsonKeys<ScaleEnd>& scale_end_keys() {
  static const JsonKeys<ScaleEnd> keys{
      {"scipy", "", "bench scale: true where python3 has SciPy; its times and differences are null without",
       [](const ScaleEnd& end) { return end.scipy; }}};
  return keys;
}

using Jobs = std::vector<std::vector<ScaleRow>>;  // of each: its rows by threads

std::vector<ScaleRow> lattice_rows(const std::string& name, const Scene& scene, double spacing,
                                   const std::vector<int>& threads) {
  LatticeOptions lattice;
  lattice.spacing = spacing;
  lattice.box = scene.space.box;
  return scale_generate(name, scene.source.file.string(), scene.body, lattice, threads);
}

Jobs measure(const Globals& globals, const std::string& file, bool full, const SciPy& scipy,
             Progress& progress) {
  const std::vector<int> threads = thread_counts(globals);
  const Sizes sizes = sizes_of(full);
  const std::vector<LatticeCase> cases = lattice_cases();
  const std::size_t lattices = file.empty() ? cases.size() : 1;
  const auto all =
      static_cast<double>(lattices + sizes.classified.size() + sizes.evaluated.size() + sizes.many.size());
  Jobs jobs;
  const auto show = [&](const std::string& what) {
    progress.show(static_cast<double>(jobs.size()) / all, what);
  };
  if (!file.empty()) {
    show("generate");
    const Scene scene = load_scene(file, globals.set);
    for (const std::string& warning : scene.source.warnings) warn(globals, warning);
    jobs.push_back(lattice_rows(file, scene, (full ? 1 : 2) * scene.space.spacing, threads));
  } else {
    for (const LatticeCase& lattice : cases) {
      show("generate " + lattice.name);
      std::vector<std::string> set = lattice.set;
      set.insert(set.end(), globals.set.begin(), globals.set.end());
      const Scene scene = built_in_scene(set);
      jobs.push_back(
          lattice_rows(lattice.name, scene, full ? lattice.full_spacing : lattice.spacing, threads));
    }
  }
  for (const std::size_t n : sizes.classified) {
    show(fmt::format("classify {} states", n));
    jobs.push_back(scale_classify(n, globals.seed, threads, scipy));
  }
  for (const std::size_t n : sizes.evaluated) {
    show(fmt::format("evaluate {} points", n));
    jobs.push_back(scale_evaluate(n, n, globals.seed, threads, scipy));
  }
  for (const auto& [states, points] : sizes.many) {
    show(fmt::format("evaluate {} points", points));
    jobs.push_back(scale_evaluate(states, points, globals.seed, threads, scipy));
  }
  return jobs;
}

std::string number_or_dash(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

void print_text(const Globals& globals, const Jobs& jobs, const SciPy& scipy) {
  say(globals, fmt::format("{}; {}; {}", provenance("")["machine"].get<std::string>(),
                           name(instruction_set_in_use()), cholmod_blas()));
  say(globals, fmt::format("{:<28}{:>9}{:>8}{:>11}{:>7}{:>8}{:>11}{:>13}{:>11}  {}", "", "items", "threads",
                           "items/s", "gain", "serial", "work/path", "baseline/s", "differs", "baseline"));
  for (const std::vector<ScaleRow>& rows : jobs)
    for (const ScaleRow& row : rows) {
      const double bound = row.parallel ? row.parallel->work / row.parallel->path : unknown;
      say(globals,
          fmt::format("{:<28}{:>9}{:>8}{:>11.4g}{:>7.2f}{:>8}{:>11}{:>13}{:>11}  {}", row.row.name, row.row.n,
                      row.threads, 1e6 / row.row.ours_us, gain_of(row, rows.front().seconds()),
                      number_or_dash(row.serial, "{:.3f}"), number_or_dash(bound, "{:.1f}"),
                      number_or_dash(1e6 / row.row.baseline_us, "{:.4g}"),
                      number_or_dash(row.row.error.back(), "{:.1e}"), row.row.baseline));
    }
  if (!scipy.there())
    say(globals, "SciPy is not installed for python3, so nothing is compared with it: install python3-scipy");
}

// Left: gain against threads, with the fit and the bound of no serial share. Right: items a second against size.
std::string picture(const Jobs& jobs) {
  std::string blocks, gains = "x with lines lw 1 dt 3 lc rgb '#8a8a8a' title 'all parallel'", rates;
  int most = 2;
  std::map<std::string, std::string> by_size, baseline_by_size;
  for (std::size_t j = 0; j < jobs.size(); ++j) {
    const std::vector<ScaleRow>& rows = jobs[j];
    std::string points;
    for (const ScaleRow& row : rows) {
      points += fmt::format("{} {}\n", row.threads, gain_of(row, rows.front().seconds()));
      most = std::max(most, row.threads);
    }
    blocks += data_block(fmt::format("scale_{}", j), points);
    const std::string colour = line_colour(j),
                      title = fmt::format("{}, {}", rows.front().row.name, rows.front().row.n);
    gains += fmt::format(", $scale_{} with points pt 7 lc rgb '{}' title '{}' noenhanced", j, colour,
                         plain_text(title));
    if (std::isfinite(rows.front().serial))
      gains += fmt::format(", 1 / ({0} + (1 - {0}) / x) with lines lc rgb '{1}' notitle", rows.front().serial,
                           colour);
    const ScaleRow& last = rows.back();
    const std::string job = last.row.name.substr(0, last.row.name.find(' '));
    by_size[job] += fmt::format("{} {}\n", last.row.n, 1e6 / last.row.ours_us);
    if (std::isfinite(last.row.baseline_us))
      baseline_by_size[job] += fmt::format("{} {}\n", last.row.n, 1e6 / last.row.baseline_us);
  }
  std::size_t colour = 0;
  for (const auto& [job, points] : by_size) {
    blocks += data_block("size_" + job, points);
    rates += fmt::format("{}$size_{} with points pt 7 lc rgb '{}' title '{}'", rates.empty() ? "" : ", ", job,
                         line_colour(colour), job);
    if (const auto theirs = baseline_by_size.find(job); theirs != baseline_by_size.end()) {
      blocks += data_block("theirs_" + job, theirs->second);
      rates += fmt::format(", $theirs_{} with points pt 6 lc rgb '{}' title 'its baseline'", job,
                           line_colour(colour));
    }
    ++colour;
  }
  return blocks + fmt::format(
                      "set grid\nset key top left font ',9' samplen 1\nset multiplot layout 1,2\nset xlabel "
                      "'threads'\n"
                      "set ylabel 'gain over one thread'\nset xrange [1:{}]\nset yrange [0:*]\nplot {}\n"
                      "set logscale xy\nset xrange [*:*]\nset yrange [*:*]\nset xlabel 'states or points'\n"
                      "set ylabel 'a second, all threads'\nplot {}\nunset multiplot\n",
                      most, gains, rates);
}

// Whether our forces and distances are SciPy's.
bool agrees(const Jobs& jobs) {
  for (const std::vector<ScaleRow>& rows : jobs)
    for (const ScaleRow& row : rows)
      if (row.row.error.back() > same_force) return false;
  return true;
}

}  // namespace

DeclaredTable declared_bench_scale() {
  return bench_table("scale", {below("rows[]", declared(scale_keys())), declared(scale_end_keys()),
                               declared(solver_machine_keys())});
}

int bench_scale(const Globals& globals, const std::string& scene, const std::string& folder, bool full) {
  match_blas_to_processor();
  claim_bench_folder(folder, {"scale.svg"});
  const SciPy scipy;
  Progress progress(globals, "bench scale");
  const Jobs jobs = measure(globals, scene, full, scipy, progress);
  Json document{{"rows", Json::array()}};
  for (const std::vector<ScaleRow>& rows : jobs)
    for (const ScaleRow& row : rows) {
      Json json = row_json(row.row, {.scene = row.scene, .body = row.body.get(), .threads = row.threads});
      add_to(json, scale_keys(), row);
      document["rows"].push_back(std::move(json));
    }
  add_to(document, scale_end_keys(), {.scipy = scipy.there()});
  add_to(document, solver_machine_keys(), {});
  add_to(document, provenance_keys(), {});
  if (!folder.empty())
    if (const std::optional<std::string> svg = draw_svg("scale", 1000, 460, picture(jobs)))
      write_whole(std::filesystem::path(folder) / "scale.svg", *svg);
  print_text(globals, jobs, scipy);
  if (globals.json) print_json(document);
  if (agrees(jobs)) return 0;
  warn(globals, fmt::format("a result differs by more than {:g}", same_force));
  return 1;
}

}  // namespace forefeel
