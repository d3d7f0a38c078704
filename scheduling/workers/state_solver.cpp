#include "scheduling/workers/state_solver.hpp"

#include "geometry/states/energy_jet.hpp"
#include "scheduling/workers/site_solver.hpp"
#include "solver/equilibrium/linear_body.hpp"

namespace forefeel {

StateSolver::StateSolver(std::shared_ptr<SolverBasis> basis, std::shared_ptr<LinearBasis> linear,
                         Options options)
    : basis_(std::move(basis)), linear_(std::move(linear)), options_(std::move(options)) {
  if (options_.sites)
    at_sites_ = std::make_unique<SiteSolver>(options_.sites, options_.spacing, options_.displacements);
}
StateSolver::~StateSolver() = default;
StateSolver::StateSolver(StateSolver&&) noexcept = default;

Solver& StateSolver::solver() {
  if (!solver_) solver_.emplace(*basis_);
  return *solver_;
}

void StateSolver::prepare() {
  if (!linear_ && !at_sites_) solver();
}

SolveOutcome StateSolver::linear_outcome(const Vec3& x) {
  SolveOutcome outcome;
  outcome.state = linear_->at(x, options_.displacements);
  if (outcome.state.usable() && options_.jet > 1)
    outcome.state.jet = std::make_shared<const EnergyJet>(EnergyJet{.order = options_.jet});
  return outcome;
}

SolveOutcome StateSolver::reference(const Vec3& x, const SurfacePlace& site) {
  if (at_sites_) return at_sites_->reference(site, x);
  if (linear_) return linear_outcome(x);
  SolveOptions options;
  options.want_displacements = options_.displacements;
  options.jet = options_.jet;
  return solver().reference(x, options_.spacing, options);
}

SolveOptions StateSolver::quick() const {
  SolveOptions options;
  options.tolerance = options_.tolerance;
  options.want_displacements = options_.displacements;
  options.jet = options_.jet;
  options.keep_factor = true;
  return options;
}

void StateSolver::settle(SolveOutcome& outcome, const Vec3& x, const std::stop_token& stop) {
  if (outcome.state.usable()) return;
  if (stop.stop_requested())
    outcome.state.solve.status = SolveStatus::cancelled;  // a solve that was stopped has not failed
  if (outcome.state.solve.status != SolveStatus::cancelled) outcome = reference(x);
}

SolveOutcome StateSolver::from(const Equilibrium* start, const Vec3& x, std::stop_token stop,
                               const SurfacePlace& site) {
  if (at_sites_) return at_sites_->solve(site, x, start, stop);
  if (linear_) return linear_outcome(x);
  SolveOutcome outcome = solver().from(start ? *start : *solver().rest(), x, quick(), stop);
  settle(outcome, x, stop);
  return outcome;
}

std::vector<SolveOutcome> StateSolver::beside(const Equilibrium* near, const std::vector<Vec3>& xs,
                                              std::stop_token stop) {
  std::vector<SolveOutcome> outcomes;
  if (linear_) {
    for (const Vec3& x : xs) outcomes.push_back(linear_outcome(x));
    return outcomes;
  }
  outcomes = solver().beside(near ? *near : *solver().rest(), xs, quick(), stop);
  for (std::size_t i = 0; i < xs.size(); ++i) settle(outcomes[i], xs[i], stop);
  return outcomes;
}

}  // namespace forefeel
