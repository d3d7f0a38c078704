// forefeel-bench solver [SCENE]: states per second over the scene's whole lattice. With a limit on states,
// the box is shrunk towards rest until its lattice fits, for the baselines as well. The baselines are full
// Newton on Eigen's SimplicialLDLT and on CHOLMOD, in the same run and on the same number of threads. A
// baseline solves a sample of the lattice and starts each state from its lattice neighbour towards rest. Eigen is left
// out above 20,000 tetrahedra. Errors are relative to tight solves on the reference branch, at a random sample. The
// parts are limited in time, so that 40 thousand tetrahedra take less than ten minutes.

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <random>

#include "apps/bench/bench.hpp"
#include "apps/bench/bench_one_state.hpp"
#include "apps/bench/bench_row.hpp"
#include "apps/bench/bench_solver_parts.hpp"
#include "apps/bench/newton_baseline.hpp"
#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/coverage/state_space.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel {
namespace {

using SteadyClock = std::chrono::steady_clock;

BenchCase take_case(const Globals& globals, const std::string& file) {
  const Scene scene = file.empty() ? built_in_scene(globals.set) : load_scene(file, globals.set);
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  return {scene.body, scene.space, scene.source.file.string()};
}

// The box, shrunk towards rest until its lattice has no more than `most` states.
Box shrunk(const StateSpaceOptions& space, std::size_t most) {
  Box box = space.box;
  for (double share = 1; share > 0 && lattice(box, space.spacing).size() > most; share -= 1.0 / 64)
    box = {Vec3(share * space.box.low), Vec3(share * space.box.high)};
  return box;
}

constexpr int rounds = 3;
constexpr double enough = 40;                  // [s]; no further round starts after this
constexpr double most_alone = 240;             // [s]; longest run on one thread
constexpr std::size_t most_for_eigen = 20000;  // elements; above, its factor takes seconds

double peak_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return 1024 * std::strtod(line.c_str() + 6, nullptr);
  return unknown;
}

BenchRow make_row(const char* baseline, double ours, double theirs, const BaselineRun& run,
                  const Errors& errors, std::size_t n) {
  return {.name = "generate",
          .baseline = baseline,
          .ours_us = 1e6 * ours,
          .baseline_us = 1e6 * theirs,
          .error = p50_p95_max(errors.values),
          .n = n,
          .baseline_processor_us = 1e6 * theirs * run.processor_share,
          .baseline_failed = run.failed};
}

Json json_of(const BenchRow& row, const BenchCase& bench, int threads) {
  return row_json(
      row, {.scene = bench.name, .body = bench.body.get(), .threads = threads, .tolerance = bench_tolerance});
}

// Results of the rounds. Times are in seconds per state, one for each round.
struct SolverRounds {
  std::vector<double> our_times, eigen_times, cholmod_times;
  BaselineRun last_eigen, last_cholmod;
  GenerateReport report;              // of the last round
  std::vector<State> states;          // of the last round
  double scaling = unknown;           // states per second relative to one thread
  std::size_t whole = 0;              // states of the scene's whole lattice
  double bytes_per_thread = unknown;  // of our solver: its factor and all that one thread works on
  Errors errors;
  bool has_eigen() const { return !eigen_times.empty(); }
  double ours() const { return median(our_times); }
  double eigen() const { return median(eigen_times); }
  double cholmod() const { return median(cholmod_times); }
  // One for each baseline.
  std::vector<BenchRow> rows() const {
    std::vector<BenchRow> all;
    const std::size_t n = report.solved;
    if (has_eigen())
      all.push_back(make_row("Eigen SimplicialLDLT full Newton", ours(), eigen(), last_eigen, errors, n));
    all.push_back(make_row("CHOLMOD full Newton", ours(), cholmod(), last_cholmod, errors, n));
    return all;
  }
};

// Of all rounds: a round in which the baseline waited or failed marks the row.
void gather(BaselineRun& all, BaselineRun round) {
  if (all.states > 0) {
    round.processor_share = std::min(round.processor_share, all.processor_share);
    round.failed += all.failed;
  }
  all = std::move(round);
}

// A random share of the lattice, new in each round, that takes no longer than about our whole lattice.
std::vector<std::size_t> draw_sample(const Globals& globals, int round, std::size_t states) {
  std::vector<std::size_t> sample(states);
  for (std::size_t i = 0; i < sample.size(); ++i) sample[i] = i;
  std::mt19937_64 random(globals.seed + static_cast<std::uint64_t>(round));
  std::shuffle(sample.begin(), sample.end(), random);
  sample.resize(std::min(sample.size(), std::max<std::size_t>(20, states / 20)));
  return sample;
}

void run_round(const Globals& globals, const BenchCase& bench, const LatticeOptions& options, int round,
               Progress& progress, SolverRounds& m) {
  const auto show = [&](const char* what, double first, double last) {
    return [&progress, what, first, last, round](double share) {
      progress.show((round + first + (last - first) * std::min(1.0, share)) / (rounds + 1), what);
    };
  };
  const auto whole = show("whole lattice", 0, 0.5);
  whole(0);
  m.states.clear();
  m.report = generate_lattice(
      bench.body, options, [&](State s) { m.states.push_back(std::move(s)); },
      [&](std::size_t done, std::size_t total) {
        whole(static_cast<double>(done) / static_cast<double>(total));
      });
  m.our_times.push_back(m.report.seconds / static_cast<double>(std::max<std::size_t>(1, m.report.solved)));
  std::sort(m.states.begin(), m.states.end(), [](const State& a, const State& b) {
    return std::lexicographical_compare(a.at.data(), a.at.data() + 3, b.at.data(), b.at.data() + 3);
  });
  const std::vector<std::size_t> sample = draw_sample(globals, round, m.states.size());
  const double budget = std::max(2.0, m.report.seconds);
  if (bench.body->mesh.tets.size() <= most_for_eigen) {
    gather(m.last_eigen, run_baseline(Baseline::eigen_ldlt, bench, m.states, sample, options.threads, budget,
                                      show("Eigen", 0.5, 0.75)));
    m.eigen_times.push_back(m.last_eigen.per_state);
  }
  gather(m.last_cholmod, run_baseline(Baseline::cholmod, bench, m.states, sample, options.threads, budget,
                                      show("CHOLMOD", 0.75, 1)));
  m.cholmod_times.push_back(m.last_cholmod.per_state);
}

SolverRounds run_rounds(const Globals& globals, const BenchCase& bench, const LatticeOptions& options,
                        Progress& progress) {
  SolverRounds m;
  const auto begun = SteadyClock::now();
  for (int round = 0; round < rounds && (round == 0 || seconds_since(begun) < enough); ++round)
    run_round(globals, bench, options, round, progress, m);
  m.bytes_per_thread = static_cast<double>(SolverBasis(bench.body).bytes_per_solver());
  if (options.threads > 1 && m.report.seconds * options.threads < most_alone) {
    LatticeOptions alone = options;
    alone.threads = 1;
    const auto show = [&](std::size_t done, std::size_t total) {
      progress.show((rounds + 0.5 * static_cast<double>(done) / static_cast<double>(total)) / (rounds + 1),
                    "one thread");
    };
    const GenerateReport one = generate_lattice(
        bench.body, alone, [](const State&) {}, show);
    m.scaling = one.seconds / static_cast<double>(std::max<std::size_t>(1, one.solved)) / m.ours();
  }
  m.errors = sample_errors(bench, m.states, globals.seed, options.threads, [&](double share) {
    progress.show((rounds + 0.5 + 0.5 * std::min(1.0, share)) / (rounds + 1), "errors");
  });
  return m;
}

const JsonKeys<SolverRounds>& solver_keys() {
  using R = SolverRounds;
  using Key = JsonKey<R>;
  static const JsonKeys<R> keys{
      {"failed", "", "bench solver: solves that failed", [](const R& r) { return r.report.failed; }},
      {"states_of_the_scene", "", "of the whole lattice", &R::whole},
      {"speedup_over_one_thread", "1", "null: not measured", &R::scaling},
      {"errors_drawn", "", "states compared with tight solves",
       [](const R& r) { return r.errors.values.size(); }},
      {"multivalued", "",
       "states drawn that are an equilibrium of another branch than the reference; not in error",
       [](const R& r) { return r.errors.multivalued; }},
      {"off_branch", "1", "largest relative difference of their force from the reference branch",
       [](const R& r) { return r.errors.off_branch; }},
      {"baseline_states", "", "list: states solved by each baseline",
       [](const R& r) {
         return Json::array({r.last_eigen.states, r.last_cholmod.states});
       }},
      {"baseline_iterations", "", "mean of CHOLMOD's full Newton",
       [](const R& r) { return r.last_cholmod.iterations; }},
      {"baseline_failed", "", "solves of baselines that failed",
       [](const R& r) { return r.last_eigen.failed + r.last_cholmod.failed; }},
      Key{"bytes_per_thread", "bytes", "of a solving thread", &R::bytes_per_thread}.last(),
      Key{"cholmod_factor_bytes", "bytes", "of the factor of CHOLMOD",
          [](const R& r) { return r.last_cholmod.factor_bytes; }}
          .last(),
      {"peak_bytes", "bytes", "largest memory of the process", [](const R&) { return peak_bytes(); }}};
  return keys;
}

Json document_of(const BenchCase& bench, int threads, const SolverRounds& m) {
  Json document{{"rows", Json::array()}};
  for (const BenchRow& row : m.rows()) document["rows"].push_back(json_of(row, bench, threads));
  add_to(document, solver_machine_keys(), {});
  add_to(document, solver_keys(), m);
  add_to(document, provenance_keys(), {});
  return document;
}

void print_text(const Globals& globals, const BenchCase& bench, int threads, SolverRounds& m) {
  const std::size_t n = m.report.solved;
  say(globals, fmt::format("{}: {}, {} tetrahedra, {} states, {} failed, {} threads, {}", bench.name,
                           name(bench.body->material.law), bench.body->mesh.tets.size(), n, m.report.failed,
                           threads, instruction_set()));
  if (n + m.report.failed < m.whole)
    say(globals,
        fmt::format("the {} states nearest to rest, of {} in the scene's box", n + m.report.failed, m.whole));
  say(globals, fmt::format("{:<36}{:>14}{:>10}", "", "us a state", "ratio"));
  say(globals, fmt::format("{:<36}{:>14.1f}", "generate", 1e6 * m.ours()));
  for (const BenchRow& row : m.rows()) {
    const std::string mark = not_counted(row);
    say(globals, fmt::format("{:<36}{:>14.1f}{:>10}{}{}", row.baseline, row.baseline_us,
                             mark.empty() ? fmt::format("{:.1f}", row.baseline_us / row.ours_us) : "-",
                             row.baseline.starts_with("CHOLMOD") ? "  (" + cholmod_blas() + ")" : "",
                             mark.empty() ? "" : "; not counted: " + mark));
  }
  if (std::isfinite(m.scaling)) say(globals, fmt::format("{} threads over one: {:.2f}", threads, m.scaling));
  say(globals, fmt::format("memory of a thread: {:.0f} MB, CHOLMOD's factor alone {:.0f} MB, ratio {:.2f}",
                           1e-6 * m.bytes_per_thread, 1e-6 * m.last_cholmod.factor_bytes,
                           m.bytes_per_thread / m.last_cholmod.factor_bytes));
  say(globals,
      fmt::format("baselines: {} and {} states of the last round ({} and {} failed; time per solved state), "
                  "each from its "
                  "lattice neighbour's equilibrium (not charged), on the same threads",
                  m.last_eigen.states, m.last_cholmod.states, m.last_eigen.failed, m.last_cholmod.failed));
  say(globals, fmt::format("force error against tight solves ({} drawn): p50 {:.1e}, p95 {:.1e}, max {:.1e}",
                           m.errors.values.size(), m.errors.at(0.5), m.errors.at(0.95), m.errors.at(1)));
  if (m.errors.multivalued > 0)
    say(globals,
        fmt::format("multivalued: {} more states drawn are equilibria of another branch, up to {} off the "
                    "reference branch",
                    m.errors.multivalued, in_percent(m.errors.off_branch)));
}

}  // namespace

DeclaredTable declared_bench_solver() {
  return bench_table("solver",
                     {declared(solver_machine_keys()), declared(solver_keys()), declared_one_state()});
}

int bench_solver(const Globals& globals, const std::string& scene, std::size_t most_states) {
  match_blas_to_processor();
  const int threads = globals.threads > 0 ? globals.threads : omp_get_max_threads();
  BenchCase bench = take_case(globals, scene);
  if (most_states == 1) return bench_one_state(globals, bench.body, bench.space.spacing, bench.name);
  const std::size_t whole = lattice(bench.space.box, bench.space.spacing).size();
  if (most_states > 0) bench.space.box = shrunk(bench.space, most_states);
  LatticeOptions options;
  options.spacing = bench.space.spacing;
  options.box = bench.space.box;
  options.threads = threads;
  options.tolerance = bench_tolerance;
  options.want_displacements = true;

  Progress progress(globals, "bench solver");
  SolverRounds m = run_rounds(globals, bench, options, progress);
  m.whole = whole;
  if (globals.json) print_json(document_of(bench, threads, m));
  print_text(globals, bench, threads, m);
  return 0;
}

}  // namespace forefeel
