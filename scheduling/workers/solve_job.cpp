#include "scheduling/workers/solve_job.hpp"

#include <memory>
#include <vector>

namespace forefeel {

void solve_job(StateSolver& solver, const Job& job, const std::stop_token& stop,
               const std::function<double()>& now, const std::function<void(JobResult)>& give) {
  const auto result_of = [&](std::uint32_t dispatch, const Vec3& at, double started, SolveOutcome outcome) {
    outcome.state.at = at;
    if (job.site.exists()) outcome.state.site = job.site.at;
    return JobResult{.dispatch = dispatch,
                     .started = started,
                     .finished = now(),
                     .state = std::move(outcome.state),
                     .equilibrium = std::move(outcome.equilibrium),
                     .partial = std::move(outcome.partial)};
  };
  const double started = now();
  SolveOutcome first = solver.from(job.start.get(), job.at, stop, job.site);
  const std::shared_ptr<const Equilibrium> near = first.equilibrium ? first.equilibrium : job.start;
  give(result_of(job.dispatch, job.at, started, std::move(first)));
  if (job.beside.empty()) return;
  const double later = now();
  std::vector<Vec3> xs;
  for (const Job::Neighbour& neighbour : job.beside) xs.push_back(neighbour.at);
  std::vector<SolveOutcome> outcomes = solver.beside(near.get(), xs, stop);
  for (std::size_t i = 0; i < xs.size(); ++i) {
    JobResult result = result_of(job.beside[i].dispatch, xs[i], later, std::move(outcomes[i]));
    if (result.state.solve.status != SolveStatus::cancelled)
      result.finished = result.started + result.state.solve.seconds;  // the state's share of the common time
    give(std::move(result));
  }
}

}  // namespace forefeel
