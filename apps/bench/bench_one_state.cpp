// forefeel-bench solver SCENE --states 1: solves one state two spacings inward, starting from the equilibrium
// one spacing inward. Each solver runs on one thread in its own process, so that its memory can be measured:
// the peak minus that of a process that solves nothing. Analysis (ordering, symbolic factorisation) is timed
// separately, because it is done once per body.

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/bench/bench_one_state.hpp"
#include "apps/bench/bench_row.hpp"
#include "apps/bench/newton_baseline.hpp"
#include "apps/console/console.hpp"
#include "apps/scene/scene_body.hpp"
#include "geometry/common/error.hpp"
#include "solver/equilibrium/continuation.hpp"

namespace forefeel {
namespace {

using SteadyClock = std::chrono::steady_clock;

struct OneState {
  double analysis = 0, solve = 0;  // [s]
  double processor = 0;            // of the thread that solved [s]
  double bytes = 0;
  double force[3] = {};
  double residual = 0;
  int iterations = 0;
  bool converged = false;
};

struct Problem {
  std::string scene;
  std::shared_ptr<const Body> body;
  std::shared_ptr<const Discretisation> d = {};
  LocalField start = {};  // at `from`
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  double tolerance = 1e-6;
};

void take(const BenchTime& took, OneState& result) {
  result.solve = 1e-6 * took.wall_us;
  result.processor = 1e-6 * took.processor_us;
}

OneState solve_ours(const Problem& problem) {
  OneState result;
  const auto begun = SteadyClock::now();
  Continuation path(problem.d);
  result.analysis = seconds_since(begun);
  path.begin_at(problem.from, {problem.start.u, {}});
  const BenchTime start = bench_time();
  const NewtonReport report = path.advance(problem.to, 0, problem.tolerance, 30, {});
  take(bench_time() - start, result);
  for (int i = 0; i < 3; ++i) result.force[i] = report.force[i];
  result.residual = report.residual;
  result.iterations = path.iterations();
  result.converged = report.status == SolveStatus::converged;
  return result;
}

OneState solve_baseline(const Problem& problem, Baseline which) {
  OneState result;
  const auto begun = SteadyClock::now();
  BaselineNewton newton(problem.d, which);
  result.analysis = seconds_since(begun);
  std::vector<double> u = problem.start.u;
  const BenchTime start = bench_time();
  const State state = newton.solve(u, problem.to, problem.tolerance);
  take(bench_time() - start, result);
  for (int i = 0; i < 3; ++i) result.force[i] = state.force[i];
  result.residual = state.solve.residual;
  result.iterations = state.solve.iterations;
  result.converged = state.usable();
  return result;
}

// Runs work() in a child process and measures its peak memory. Returns nothing if the child fails.
template <class Work>
std::optional<OneState> alone(const Work& work) {
  int ends[2];
  if (pipe(ends) != 0) return std::nullopt;
  const pid_t child = fork();
  if (child < 0) return std::nullopt;
  if (child == 0) {
    const OneState result = work();
    const bool whole = write(ends[1], &result, sizeof result) == static_cast<ssize_t>(sizeof result);
    _exit(whole ? 0 : 1);
  }
  close(ends[1]);
  OneState result;
  const bool whole = read(ends[0], &result, sizeof result) == static_cast<ssize_t>(sizeof result);
  close(ends[0]);
  rusage usage{};
  int status = 0;
  wait4(child, &status, 0, &usage);
  if (!whole || status != 0) return std::nullopt;
  result.bytes = 1024.0 * static_cast<double>(usage.ru_maxrss);
  return result;
}

Problem problem_of(std::shared_ptr<const Body> body, double spacing, const std::string& scene) {
  Problem problem{.scene = scene, .body = std::move(body)};
  problem.d = std::make_shared<const Discretisation>(discretise(*problem.body));
  problem.from = spacing * inward_direction(*problem.body);
  problem.to = 2 * problem.from;
  Continuation path(problem.d);
  path.begin_at_rest();
  const NewtonReport report = path.advance(problem.from, 0, 1e-10, 60, {});
  if (report.status != SolveStatus::converged)
    throw InputError(scene,
                     fmt::format("the state one spacing inward ended as {}, expected one that converges",
                                 name(report.status)));
  problem.start = path.field();
  return problem;
}

struct SolverRow {
  const char* name;
  std::optional<OneState> result;
  bool solved() const { return result && result->converged; }
};

// Our row first, without the memory of a process that solves nothing.
std::vector<SolverRow> solve_alone(const Problem& problem, Progress& progress) {
  std::vector<SolverRow> rows{
      {"forefeel", {}}, {"CHOLMOD full Newton", {}}, {"Eigen SimplicialLDLT full Newton", {}}};
  const std::optional<OneState> nothing = alone([] { return OneState{}; });
  rows[0].result = alone([&] { return solve_ours(problem); });
  progress.show(0.1, "CHOLMOD");
  rows[1].result = alone([&] { return solve_baseline(problem, Baseline::cholmod); });
  progress.show(0.3, "Eigen");
  rows[2].result = alone([&] { return solve_baseline(problem, Baseline::eigen_ldlt); });
  for (SolverRow& row : rows)
    if (nothing && row.result) row.result->bytes -= nothing->bytes;
  return rows;
}

struct OneStatePair {
  const OneState &ours, &baseline;
};

// Both values of a number.
template <class Value>
auto both(Value OneState::*member, Value factor = 1) {
  return [=](const OneStatePair& p) {
    return Json::array({*json_value(factor * p.ours.*member), *json_value(factor * p.baseline.*member)});
  };
}

const JsonKeys<OneStatePair>& one_state_keys() {
  static const JsonKeys<OneStatePair> keys{
      {"ours_bytes,baseline_bytes", "bytes", "with --states 1: memory of one state", both(&OneState::bytes)},
      {"ours_analysis_us,baseline_analysis_us", "us", "with --states 1: symbolic analysis",
       both(&OneState::analysis, 1e6)},
      {"ours_iterations,baseline_iterations", "", "with --states 1: Newton iterations",
       both(&OneState::iterations)}};
  return keys;
}

BenchRow bench_row(const SolverRow& row, const OneState& ours, double apart) {
  const OneState& r = *row.result;
  return {.name = "one state",
          .baseline = row.name,
          .ours_us = 1e6 * ours.solve,
          .baseline_us = 1e6 * r.solve,
          .error = {apart, apart, apart},
          .n = 1,
          .baseline_processor_us = 1e6 * r.processor,
          .baseline_failed = row.solved() ? 0u : 1u};
}

Json one_state_json(const Problem& problem, const BenchRow& row, const OneState& ours, const OneState& r) {
  Json json = row_json(
      row, BenchSubject{.scene = problem.scene, .body = problem.body.get(), .tolerance = problem.tolerance});
  add_to(json, one_state_keys(), {ours, r});
  return json;
}

}  // namespace

const JsonKeys<BenchEnd>& solver_machine_keys() {
  static const JsonKeys<BenchEnd> keys{
      JsonKey<BenchEnd>("blas", "", "library behind CHOLMOD", [](const BenchEnd&) { return cholmod_blas(); })
          .last(),
      instruction_set_key(instruction_set())};
  return keys;
}

std::vector<Declared> declared_one_state() {
  return below("rows[]", declared(one_state_keys()));
}

int bench_one_state(const Globals& globals, std::shared_ptr<const Body> body, double spacing,
                    const std::string& scene) {
  Progress progress(globals, "bench solver");
  progress.show(0, "the neighbour");
  const Problem problem = problem_of(body, spacing, scene);
  const std::vector<SolverRow> rows = solve_alone(problem, progress);
  for (const SolverRow& row : rows)
    if (!row.solved()) warn(globals, fmt::format("{} did not solve the state", row.name));
  if (!rows[0].result) return 1;

  const OneState& ours = *rows[0].result;
  const Vec3 force(ours.force[0], ours.force[1], ours.force[2]);
  Json document{{"rows", Json::array()}};
  say(globals, fmt::format("{}: {}, {} tetrahedra, {} free nodes, one state, one thread, {}; {}", scene,
                           name(body->material.law), body->mesh.tets.size(), problem.d->free_nodes,
                           instruction_set(), cholmod_blas()));
  say(globals, fmt::format("{:<36}{:>14}{:>12}{:>12}{:>10}{:>14}{:>12}", "", "analysis s", "solve s",
                           "iterations", "MB", "force differs", "time ratio"));
  bool all = true;
  for (const SolverRow& row : rows) {
    all = all && row.solved();
    if (!row.result) continue;
    const OneState& r = *row.result;
    const double apart = (Vec3(r.force[0], r.force[1], r.force[2]) - force).norm() / force.norm();
    const BenchRow made = bench_row(row, ours, apart);
    const std::string mark = not_counted(made);
    say(globals, fmt::format("{:<36}{:>14.3f}{:>12.3f}{:>12}{:>10.0f}{:>14.1e}{:>12}{}", row.name, r.analysis,
                             r.solve, r.iterations, 1e-6 * r.bytes, apart,
                             mark.empty() ? fmt::format("{:.2f}", r.solve / ours.solve) : "-",
                             mark.empty() ? "" : "  not counted: " + mark));
    if (&row == &rows.front()) continue;
    document["rows"].push_back(one_state_json(problem, made, ours, r));
  }
  add_to(document, solver_machine_keys(), {});
  add_to(document, provenance_keys(), {});
  if (globals.json) print_json(document);
  return all ? 0 : 1;
}

}  // namespace forefeel
