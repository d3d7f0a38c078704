#include <omp.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <exception>
#include <map>
#include <optional>

#include "geometry/state_space.hpp"
#include "solver/solver.hpp"

namespace forefeel {
namespace {

using LatticeIndex = std::array<int, 3>;

LatticeIndex index_of(const Vec3& x, double spacing) {
  LatticeIndex k{};
  for (std::size_t i = 0; i < 3; ++i) k[i] = static_cast<int>(std::lround(x[static_cast<Eigen::Index>(i)] / spacing));
  return k;
}

int level(const LatticeIndex& k) { return std::abs(k[0]) + std::abs(k[1]) + std::abs(k[2]); }

// One step towards rest along the longest component.
LatticeIndex parent(LatticeIndex k) {
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (std::abs(k[i]) > std::abs(k[longest])) longest = i;
  k[longest] -= k[longest] > 0 ? 1 : k[longest] < 0 ? -1 : 0;
  return k;
}

}  // namespace

GenerateReport generate_lattice(std::shared_ptr<const Body> body, const GenerateOptions& options,
                                const std::vector<State>& known, const std::function<void(State)>& sink,
                                const std::function<void(std::size_t, std::size_t)>& progress) {
  const auto start = std::chrono::steady_clock::now();
  GenerateReport report;
  report.threads = options.threads > 0 ? options.threads : omp_get_max_threads();
  std::map<LatticeIndex, bool> there;
  for (const State& state : known) {
    const LatticeIndex k = index_of(state.at, options.spacing);
    const Vec3 exact(k[0] * options.spacing, k[1] * options.spacing, k[2] * options.spacing);
    if ((state.at - exact).norm() < 1e-6 * options.spacing) there[k] = true;
  }
  std::map<int, std::vector<Vec3>> levels;
  std::size_t total = 0, done = 0;
  for (const Vec3& x : lattice(options.box, options.spacing)) {
    ++total;
    if (there.count(index_of(x, options.spacing)) != 0)
      ++report.resumed;
    else
      levels[level(index_of(x, options.spacing))].push_back(x);
  }
  done = report.resumed;
  std::vector<Solver> solvers;
  for (int i = 0; i < report.threads; ++i) solvers.emplace_back(body);
  std::map<LatticeIndex, std::shared_ptr<const Equilibrium>> before, now;
  std::exception_ptr failure;
  for (const auto& [number, positions] : levels) {
    now.clear();
#pragma omp parallel for schedule(dynamic) num_threads(report.threads)
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (options.stop.stop_requested()) continue;
      Solver& solver = solvers[static_cast<std::size_t>(omp_get_thread_num())];
      const LatticeIndex k = index_of(positions[i], options.spacing);
      SolveOptions solve;
      solve.tolerance = options.tolerance;
      solve.want_displacements = options.want_displacements;
      const auto from = before.find(parent(k));
      SolveOutcome outcome = from != before.end() && from->second
                                 ? solver.from(*from->second, positions[i], solve, options.stop)
                                 : solver.reference(positions[i], options.spacing, solve);
      if (outcome.state.status == SolveStatus::cancelled) continue;
#pragma omp critical(forefeel_generate)
      {
        try {
          now[k] = outcome.equilibrium;
          (outcome.state.usable() ? report.solved : report.failed) += 1;
          sink(std::move(outcome.state));
          if (progress) progress(++done, total);
        } catch (...) {
          failure = std::current_exception();
        }
      }
    }
    if (failure) std::rethrow_exception(failure);
    before.swap(now);
    if (options.stop.stop_requested()) break;
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace forefeel
