#include "scheduling/workers/state_solver.hpp"

#include <algorithm>

namespace forefeel {

void LinearBasis::solve() {
  Solver solver(body_);
  residual_ = seconds_ = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const SolveOutcome outcome = solver.reference(spacing_ * Vec3::Unit(axis), spacing_);
    if (!outcome.state.usable() || !outcome.equilibrium) {
      status_ = outcome.state.status;
      return;
    }
    stiffness_.col(axis) = -outcome.state.force / spacing_;
    displacements_[axis] = outcome.equilibrium->displacements;
    for (double& u : displacements_[axis]) u /= spacing_;
    residual_ = std::max(residual_, outcome.state.residual);
    seconds_ += outcome.state.seconds;
    iterations_ += outcome.state.iterations;
  }
  stiffness_ = 0.5 * (stiffness_ + stiffness_.transpose()).eval();  // symmetric but for round-off
  status_ = SolveStatus::converged;
}

SolveOutcome LinearBasis::at(const Vec3& x, bool want_displacements) {
  std::call_once(once_, [this] { solve(); });
  SolveOutcome outcome;
  State& state = outcome.state;
  state.at = x;
  state.status = status_;
  if (status_ != SolveStatus::converged) return outcome;
  state.force = -stiffness_ * x;
  state.stiffness = stiffness_;
  state.energy = 0.5 * x.dot(stiffness_ * x);
  state.residual = residual_;
  state.seconds = 0;  // the three solves are paid once for all states
  state.iterations = 0;
  state.parent = Vec3::Zero();
  if (want_displacements) {
    std::vector<double> u(displacements_[0].size());
    for (std::size_t i = 0; i < u.size(); ++i)
      u[i] = x[0] * displacements_[0][i] + x[1] * displacements_[1][i] + x[2] * displacements_[2][i];
    state.displacements = std::make_shared<const std::vector<double>>(std::move(u));
  }
  return outcome;
}

std::shared_ptr<LinearBasis> linear_basis(const std::shared_ptr<const Body>& body, double spacing) {
  return is_linear(*body) ? std::make_shared<LinearBasis>(body, spacing) : nullptr;
}

StateSolver::StateSolver(std::shared_ptr<const Body> body, std::shared_ptr<LinearBasis> linear,
                         Options options)
    : body_(std::move(body)), linear_(std::move(linear)), options_(options) {}

Solver& StateSolver::solver() {
  if (!solver_) solver_.emplace(body_);
  return *solver_;
}

void StateSolver::prepare() {
  if (!linear_) solver();
}

SolveOutcome StateSolver::reference(const Vec3& x) {
  if (linear_) return linear_->at(x, options_.displacements);
  SolveOptions options;
  options.want_displacements = options_.displacements;
  return solver().reference(x, options_.spacing, options);
}

SolveOptions StateSolver::quick() const {
  SolveOptions options;
  options.tolerance = options_.tolerance;
  options.want_displacements = options_.displacements;
  options.keep_factor = true;
  return options;
}

void StateSolver::settle(SolveOutcome& outcome, const Vec3& x, const std::stop_token& stop) {
  if (outcome.state.usable()) return;
  if (stop.stop_requested())
    outcome.state.status = SolveStatus::cancelled;  // however it ended: it proves nothing
  if (outcome.state.status != SolveStatus::cancelled) outcome = reference(x);
}

SolveOutcome StateSolver::from(const Equilibrium* start, const Vec3& x, std::stop_token stop) {
  if (linear_) return linear_->at(x, options_.displacements);
  SolveOutcome outcome = solver().from(start ? *start : *solver().rest(), x, quick(), stop);
  settle(outcome, x, stop);
  return outcome;
}

std::vector<SolveOutcome> StateSolver::beside(const Equilibrium* near, const std::vector<Vec3>& xs,
                                              std::stop_token stop) {
  std::vector<SolveOutcome> outcomes;
  if (linear_) {
    for (const Vec3& x : xs) outcomes.push_back(linear_->at(x, options_.displacements));
    return outcomes;
  }
  outcomes = solver().beside(near ? *near : *solver().rest(), xs, quick(), stop);
  for (std::size_t i = 0; i < xs.size(); ++i) settle(outcomes[i], xs[i], stop);
  return outcomes;
}

}  // namespace forefeel
