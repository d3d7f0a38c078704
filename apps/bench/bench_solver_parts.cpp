#include "apps/bench/bench_solver_parts.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "apps/bench/bench_row.hpp"
#include "apps/console/console.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/system/discretisation.hpp"

namespace forefeel {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t error_sample = 60;
constexpr double time_for_errors = 120;  // [s]
constexpr double suspect = 1e-3;  // relative difference from the reference branch that is looked at again

// Displacements of a state; mid-edge nodes lie halfway between the ends of their edge.
std::vector<double> local_field(const Discretisation& d, const State& state) {
  std::vector<double> u(static_cast<std::size_t>(d.local_size())), by_node = *state.displacements;
  for (const auto& [a, b] : d.edges)
    for (std::size_t c = 0; c < 3; ++c)
      by_node.push_back(0.5 * (by_node[3 * static_cast<std::size_t>(a) + c] +
                               by_node[3 * static_cast<std::size_t>(b) + c]));
  d.to_local(by_node, u.data());
  return u;
}

// How far the force stays from that of the reference branch when the state is solved tightly from its own displacements
// [N]; 0 where that fails.
double off_reference(const std::shared_ptr<const Discretisation>& d, const State& state,
                     const Vec3& reference) {
  if (!state.displacements) return 0;
  std::vector<double> u = local_field(*d, state);
  const State tight = BaselineNewton(d, Baseline::cholmod).solve(u, state.at, 1e-9);
  return tight.usable() ? (tight.force - reference).norm() : 0;
}

}  // namespace

Errors sample_errors(const BenchCase& bench, const std::vector<State>& states, std::uint64_t seed,
                     int threads, const ShowShare& show) {
  std::mt19937_64 random(seed + 1);
  std::vector<const State*> sample;
  for (const State& s : states)
    if (s.usable() && s.at.norm() > 0) sample.push_back(&s);
  std::shuffle(sample.begin(), sample.end(), random);
  sample.resize(std::min(sample.size(), error_sample));
  std::vector<double> values(sample.size(), unknown), elsewhere(sample.size(), 0);
  const auto d = std::make_shared<const Discretisation>(discretise(*bench.body));
  SolverBasis basis(bench.body);
  const auto start = SteadyClock::now();
  std::size_t done = 0;
#pragma omp parallel num_threads(threads)
  {
    Solver solver(basis);
#pragma omp for schedule(dynamic)
    for (std::size_t i = 0; i < sample.size(); ++i) {
      if (seconds_since(start) > time_for_errors) continue;
#pragma omp critical(forefeel_bench_solver)
      show(std::max(static_cast<double>(++done) / static_cast<double>(sample.size()),
                    seconds_since(start) / time_for_errors));
      const State tight = solver.reference(sample[i]->at, bench.space.spacing).state;
      if (!tight.usable()) continue;
      const double size = std::max(tight.force.norm(), 0.05);
      values[i] = (sample[i]->force - tight.force).norm() / size;
      if (values[i] > suspect) elsewhere[i] = off_reference(d, *sample[i], tight.force) / size;
    }
  }
  Errors errors;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    if (elsewhere[i] > 0.5 * values[i]) {
      ++errors.multivalued;
      errors.off_branch = std::max(errors.off_branch, values[i]);
    } else {
      errors.values.push_back(values[i]);
    }
  }
  return errors;
}

BaselineRun run_baseline(Baseline which, const BenchCase& bench, const std::vector<State>& states,
                         const std::vector<std::size_t>& sample, int threads, double budget,
                         const ShowShare& show) {
  const auto d = std::make_shared<const Discretisation>(discretise(*bench.body));
  const double h = bench.space.spacing;
  const auto key = [&](const Vec3& x) {
    return std::array<long, 3>{std::lround(x[0] / h), std::lround(x[1] / h), std::lround(x[2] / h)};
  };
  std::map<std::array<long, 3>, const State*> known;
  for (const State& s : states)
    if (s.displacements) known[key(s.at)] = &s;
  std::vector<std::pair<Vec3, std::vector<double>>> starts;
  for (const std::size_t i : sample) {
    std::array<long, 3> k = key(states[i].at);
    const auto longest = static_cast<std::size_t>(
        std::max_element(k.begin(), k.end(), [](long a, long b) { return std::abs(a) < std::abs(b); }) -
        k.begin());
    k[longest] -= k[longest] > 0 ? 1 : k[longest] < 0 ? -1 : 0;
    const auto from = known.find(k);
    if (from == known.end()) continue;
    starts.emplace_back(states[i].at, local_field(*d, *from->second));
  }
  BaselineRun run;
  run.solved.resize(starts.size());
  std::vector<std::unique_ptr<BaselineNewton>> solvers;
  for (int i = 0; i < threads; ++i) solvers.push_back(std::make_unique<BaselineNewton>(d, which));
  double wall = 0, processor = 0;  // [us], of all solves
  const auto start = SteadyClock::now();
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (std::size_t i = 0; i < starts.size(); ++i)
    if (seconds_since(start) < budget) {
      const BenchTime begun = bench_time();
      run.solved[i] = solvers[static_cast<std::size_t>(omp_get_thread_num())]->solve(
          starts[i].second, starts[i].first, bench_tolerance);
      const BenchTime took = bench_time() - begun;
#pragma omp critical(forefeel_bench_solver)
      {
        wall += took.wall_us, processor += took.processor_us;
        show(seconds_since(start) / budget);
      }
    }
  const double seconds = seconds_since(start);
  if (wall > 0) run.processor_share = processor / wall;
  run.factor_bytes = solvers.front()->factor_bytes();
  std::erase_if(run.solved,
                [](const State& s) { return s.solve.status == SolveStatus::measured; });  // not started
  for (const State& s : run.solved) {
    run.failed += !s.usable();
    run.iterations += s.solve.iterations;
  }
  run.states = run.solved.size();
  run.iterations /= static_cast<double>(std::max<std::size_t>(1, run.states));
  run.per_state = seconds / static_cast<double>(std::max<std::size_t>(1, run.states - run.failed));
  return run;
}

}  // namespace forefeel
