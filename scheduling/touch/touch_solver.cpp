#include "scheduling/touch/touch_solver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <utility>

#include "geometry/states/energy_jet.hpp"

namespace forefeel {

void TouchStarts::add(const SurfacePlace& site, std::shared_ptr<const Equilibrium> equilibrium) {
  constexpr std::size_t most = 64;
  if (!equilibrium) return;
  starts_.push_back({site, std::move(equilibrium)});
  if (starts_.size() > most) starts_.pop_front();
}

std::shared_ptr<const Equilibrium> TouchStarts::near(const SurfacePlace& site, const Vec3& x) const {
  double least = x.norm();
  std::shared_ptr<const Equilibrium> best;
  for (const Start& start : starts_) {
    const double way = (start.equilibrium->at - x).norm() + (start.site.at - site.at).norm();
    if (way < least) least = way, best = start.equilibrium;
  }
  return best;
}

TouchSolved solved_by(TouchSolver& solver, const TouchJob& job, const std::stop_token& stop) {
  try {
    return solver.solve(job, stop);
  } catch (const std::exception&) {
    TouchSolved failed;
    failed.state.at = job.x, failed.state.site = job.site.at;
    failed.state.solve.status = SolveStatus::diverged;
    return failed;
  }
}

TouchSolver::TouchSolver(std::shared_ptr<const RestSites> sites, double step)
    : sites_(std::move(sites)), step_(step) {}
TouchSolver::~TouchSolver() = default;
TouchSolver::TouchSolver(TouchSolver&&) noexcept = default;

Solver& TouchSolver::at(const SurfacePlace& site) {
  if (!solver_ || last_.facet != site.facet || last_.at != site.at) {
    Body there = sites_->body();
    there.fine.reset();  // of the sites' body, which is the one that is answered for
    there.pad->site = site.at;
    solver_ = std::make_unique<Solver>(std::move(there));
    last_ = site;
    rest_.reset();
  }
  return *solver_;
}

bool TouchSolver::is_expected(const SurfacePlace& site, const State& state) {
  constexpr double agreement = 0.01;
  if (!rest_) {
    if (!jets_) jets_ = std::make_unique<SiteJets>(*sites_);
    rest_ = jets_->at(site);
  }
  const Vec3 last = jet_terms(rest_->jet, state.at, 5).gradient,
             before = jet_terms(rest_->jet, state.at, 4).gradient,
             first = jet_terms(rest_->jet, state.at, 3).gradient;
  const double own = std::hypot((last - before).norm(), 0.5 * (before - first).norm());
  const double off = (state.force + rest_->stiffness * state.at + last).norm();
  return off <= std::max(own, agreement * state.force.norm());
}

TouchSolved TouchSolver::solve(const TouchJob& job, const std::stop_token& stop) {
  TouchSolved solved;
  if (job.x.isZero(0)) {
    const auto start = std::chrono::steady_clock::now();
    if (!jets_) jets_ = std::make_unique<SiteJets>(*sites_);
    const RestJet jet = jets_->at(job.site);
    State& state = solved.state;
    state.force.setZero();
    state.energy = 0;
    state.stiffness = jet.stiffness;
    state.jet = std::make_shared<const EnergyJet>(jet.jet);
    state.solve.status = SolveStatus::converged;
    state.solve.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    state.site = job.site.at;
    return solved;
  }
  Solver& solver = at(job.site);
  SolveOptions options;
  options.tolerance = 1e-9;  // a jet's terms need an equilibrium
  options.jet = most_jet_order;
  SolveOutcome outcome = solver.from(job.start ? *job.start : *solver.rest(), job.x, options, stop);
  if (!stop.stop_requested() && !(outcome.state.usable() && is_expected(job.site, outcome.state))) {
    SolveOutcome straight = solver.reference(job.x, step_, options);
    if (straight.state.usable()) {
      straight.state.solve.multivalued |=
          outcome.state.usable() &&
          (straight.state.force - outcome.state.force).norm() > 1e-6 * straight.state.force.norm();
      straight.state.solve.seconds += outcome.state.solve.seconds;
      outcome = std::move(straight);
    }
  }
  if (!outcome.state.usable() && stop.stop_requested()) outcome.state.solve.status = SolveStatus::cancelled;
  solved.state = std::move(outcome.state);
  solved.state.site = job.site.at;
  solved.equilibrium = std::move(outcome.equilibrium);
  return solved;
}

State TouchSolver::reference(const SurfacePlace& site, const Vec3& x) {
  State state = at(site).reference(x, step_).state;
  state.site = site.at;
  return state;
}

}  // namespace forefeel
