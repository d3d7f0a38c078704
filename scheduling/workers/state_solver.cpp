#include "scheduling/workers/state_solver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <utility>

#include "geometry/states/energy_jet.hpp"
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

SiteSolver::SiteSolver(std::shared_ptr<const RestSites> sites, double step, bool displacements)
    : sites_(std::move(sites)), step_(step), displacements_(displacements) {}
SiteSolver::~SiteSolver() = default;

Solver& SiteSolver::at(const SurfacePlace& site) {
  if (!solver_ || last_ != site) {
    Body there = sites_->body();
    there.fine.reset();  // of the sites' body, which is the one that is answered for
    there.pad->site = site.at;
    solver_ = std::make_unique<Solver>(std::move(there));
    last_ = site;
  }
  return *solver_;
}

const RestJet& SiteSolver::rest(const SurfacePlace& site) {
  if (!rest_ || rest_of_ != site) {
    if (!jets_) jets_ = std::make_unique<SiteJets>(*sites_);
    rest_ = jets_->at(site);
    rest_of_ = site;
  }
  return *rest_;
}

bool SiteSolver::is_expected(const SurfacePlace& site, const State& state) {
  constexpr double agreement = 0.01;
  const RestJet& at_rest = rest(site);
  const Vec3 last = jet_terms(at_rest.jet, state.at, 5).gradient,
             before = jet_terms(at_rest.jet, state.at, 4).gradient,
             first = jet_terms(at_rest.jet, state.at, 3).gradient;
  const double own = std::hypot((last - before).norm(), 0.5 * (before - first).norm());
  const double off = (state.force + at_rest.stiffness * state.at + last).norm();
  return off <= std::max(own, agreement * state.force.norm());
}

SolveOutcome SiteSolver::at_rest(const SurfacePlace& site) {
  const auto start = std::chrono::steady_clock::now();
  const RestJet& jet = rest(site);
  SolveOutcome outcome;
  State& state = outcome.state;
  state.force.setZero();
  state.energy = 0;
  state.stiffness = jet.stiffness;
  state.jet = std::make_shared<const EnergyJet>(jet.jet);
  if (displacements_)
    state.displacements =
        std::make_shared<const std::vector<double>>(3 * sites_->body().mesh.nodes.size(), 0.0);
  state.solve.status = SolveStatus::converged;
  state.solve.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  state.site = site.at;
  return outcome;
}

namespace {

SolveOptions options_of(bool displacements) {
  SolveOptions options;
  options.tolerance = 1e-9;  // a jet's terms need an equilibrium
  options.jet = most_jet_order;
  options.want_displacements = displacements;
  return options;
}

// A place that cannot be solved has failed, and the worker goes on.
SolveOutcome failed(const SurfacePlace& site, const Vec3& x) {
  SolveOutcome outcome;
  outcome.state.at = x, outcome.state.site = site.at;
  outcome.state.solve.status = SolveStatus::diverged;
  return outcome;
}

}  // namespace

SolveOutcome SiteSolver::solve(const SurfacePlace& site, const Vec3& x, const Equilibrium* start,
                               const std::stop_token& stop) try {
  if (x.isZero(0)) return at_rest(site);
  Solver& solver = at(site);
  const SolveOptions options = options_of(displacements_);
  SolveOutcome outcome = solver.from(start ? *start : *solver.rest(), x, options, stop);
  if (!stop.stop_requested() && !(outcome.state.usable() && is_expected(site, outcome.state))) {
    SolveOutcome straight = solver.reference(x, step_, options);
    if (straight.state.usable()) {
      straight.state.solve.multivalued |=
          outcome.state.usable() &&
          (straight.state.force - outcome.state.force).norm() > 1e-6 * straight.state.force.norm();
      straight.state.solve.seconds += outcome.state.solve.seconds;
      outcome = std::move(straight);
    }
  }
  if (!outcome.state.usable() && stop.stop_requested()) outcome.state.solve.status = SolveStatus::cancelled;
  outcome.state.site = site.at;
  return outcome;
} catch (const std::exception&) {
  return failed(site, x);
}

SolveOutcome SiteSolver::reference(const SurfacePlace& site, const Vec3& x) try {
  if (x.isZero(0)) return at_rest(site);
  SolveOptions options = options_of(displacements_);
  options.tolerance = SolveOptions{}.tolerance;
  SolveOutcome outcome = at(site).reference(x, step_, options);
  outcome.state.site = site.at;
  return outcome;
} catch (const std::exception&) {
  return failed(site, x);
}

}  // namespace forefeel
