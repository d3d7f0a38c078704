#include <omp.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <set>
#include <tuple>

#include "geometry/states/state_outcome.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel {
namespace {

using ExactPlace = std::tuple<double, double, double>;
ExactPlace exact(const Vec3& at) {
  return {at.x() + 0.0, at.y() + 0.0, at.z() + 0.0};
}

}  // namespace

GenerateReport generate_places(std::shared_ptr<const Body> body, std::span<const Vec3> places,
                               const LatticeOptions& options, const std::function<void(State)>& sink,
                               const std::function<void(std::size_t, std::size_t)>& progress,
                               const std::vector<State>& known) {
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  std::set<ExactPlace> there;
  for (const State& state : known) there.insert(exact(state.at));
  std::vector<Vec3> missing;
  std::ranges::copy_if(places, std::back_inserter(missing),
                       [&](const Vec3& at) { return there.insert(exact(at)).second; });
  GenerateReport report;
  report.resumed = places.size() - missing.size();
  report.threads = options.threads > 0 ? options.threads : omp_get_max_threads();
  std::mutex mutex;  // of report and of what follows
  std::exception_ptr failure;
  std::atomic<bool> ended = false;
#pragma omp parallel num_threads(report.threads)
  {
    Solver solver(body);
#pragma omp for schedule(dynamic)
    for (std::size_t i = 0; i < missing.size(); ++i) {
      if (ended || options.stop.stop_requested()) continue;
      try {
        const double began = seconds();
        const SolveOptions exactly{.want_displacements = options.want_displacements, .jet = options.jet};
        State state = solver.reference(missing[i], options.spacing, exactly).state;
        if (state.usable()) state.solve.multivalued = second_way_differs(solver, state, options.spacing);
        const std::lock_guard lock(mutex);
        if (ended || state.solve.status == SolveStatus::cancelled) continue;
        const double took = seconds() - began;
        report.parallel.work += took;
        report.parallel.path = std::max(report.parallel.path, took);
        (state.usable() ? report.solved : report.failed) += 1;
        report.inverted += has_inverted_elements(state);
        sink(std::move(state));
        if (progress) progress(report.resumed + report.solved + report.failed, places.size());
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        ended = true;
      }
    }
  }
  if (failure) std::rethrow_exception(failure);
  report.seconds = seconds();
  report.parallel.idle = std::max(0.0, report.threads * report.seconds - report.parallel.work);
  return report;
}

}  // namespace forefeel
