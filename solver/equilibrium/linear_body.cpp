#include "solver/equilibrium/linear_body.hpp"

#include <algorithm>
#include <cmath>

#include "solver/equilibrium/continuation.hpp"

namespace forefeel {

LinearBody::LinearBody(const Discretisation& d, NewtonSolver& newton) : d_(d) {
  const std::vector<double> rest(static_cast<std::size_t>(d.local_size()), 0.0);
  solvable_ = newton.factorise(rest);
  if (!solvable_) return;
  tangent_.resize(3 * rest.size());
  newton.factor().tangent(tangent_.data());
  stiffness_ = newton.factor().stiffness();
}

State LinearBody::state(const Vec3& x, LocalField& field) const {
  State s;
  s.at = x;
  s.solve.status = SolveStatus::diverged;
  if (!solvable_) return s;
  field.u.assign(static_cast<std::size_t>(d_.local_size()), 0.0);
  field.tangent = tangent_;
  const LocalField rest = field;
  detail::predict(rest, x, x, field.u);
  std::vector<double> gradient(field.u.size(), 0.0);
  s.solve.min_jacobian = d_.elements.gradient(field.u.data(), gradient.data()).min_jacobian;
  double squares = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(3 * d_.free_nodes); ++i)
    squares += gradient[i] * gradient[i];
  s.force = -stiffness_ * x;
  s.stiffness = stiffness_;
  s.energy = 0.5 * x.dot(stiffness_ * x);
  s.solve.residual = std::sqrt(squares) / std::max(s.force.norm(), d_.force_floor);
  s.solve.iterations = 1;
  s.solve.status = s.solve.residual < 1e-8 ? SolveStatus::converged : SolveStatus::diverged;
  return s;
}

LinearBasis::LinearBasis(std::shared_ptr<const Body> body, double spacing)
    : body_(std::move(body)), spacing_(spacing) {}

void LinearBasis::solve() {
  d_ = std::make_shared<const Discretisation>(discretise(*body_));
  NewtonSolver newton(d_);
  const LinearBody linear(*d_, newton);
  LocalField field;
  for (int axis = 0; axis < 3; ++axis) {
    const State state = linear.state(spacing_ * Vec3::Unit(axis), field);
    if (!state.usable()) {
      status_ = state.solve.status;
      return;
    }
    stiffness_.col(axis) = -state.force / spacing_;
    std::vector<double>& u = displacements_[axis];
    local_[axis] = field.u;
    for (double& component : local_[axis]) component /= spacing_;
    u = d_->to_nodes(field.u.data());
    u.resize(3 * body_->mesh.nodes.size());  // mid-edge nodes are not reported
    for (double& component : u) component /= spacing_;
    residual_ = std::max(residual_, state.solve.residual);
  }
  stiffness_ = 0.5 * (stiffness_ + stiffness_.transpose()).eval();  // symmetric but for round-off
  status_ = SolveStatus::converged;
}

double LinearBasis::min_jacobian(const Vec3& x) const {
  std::vector<double> u(local_[0].size()), gradient(u.size(), 0.0);
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] = x[0] * local_[0][i] + x[1] * local_[1][i] + x[2] * local_[2][i];
  return d_->elements.gradient(u.data(), gradient.data()).min_jacobian;
}

State LinearBasis::at(const Vec3& x, bool want_displacements) {
  std::call_once(once_, [this] { solve(); });
  State state;
  state.at = x;
  state.solve.status = status_;
  if (status_ != SolveStatus::converged) return state;
  state.force = -stiffness_ * x;
  state.stiffness = stiffness_;
  state.energy = 0.5 * x.dot(stiffness_ * x);
  state.solve.residual = residual_;
  state.solve.min_jacobian = min_jacobian(x);
  state.solve.seconds = 0;
  state.solve.iterations = 0;
  state.solve.parent = Vec3::Zero();
  if (want_displacements) {
    std::vector<double> u(displacements_[0].size());
    for (std::size_t i = 0; i < u.size(); ++i)
      u[i] = x[0] * displacements_[0][i] + x[1] * displacements_[1][i] + x[2] * displacements_[2][i];
    state.displacements = std::make_shared<const std::vector<double>>(std::move(u));
  }
  return state;
}

std::shared_ptr<LinearBasis> linear_basis(const std::shared_ptr<const Body>& body, double spacing) {
  return is_linear(*body) ? std::make_shared<LinearBasis>(body, spacing) : nullptr;
}

}  // namespace forefeel
