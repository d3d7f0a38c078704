#include "scheduling/workers/site_solver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <utility>

#include "geometry/states/energy_jet.hpp"

namespace forefeel {

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
