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
  s.status = SolveStatus::diverged;
  if (!solvable_) return s;
  field.u.assign(static_cast<std::size_t>(d_.local_size()), 0.0);
  field.tangent = tangent_;
  const LocalField rest = field;
  predict(d_, rest, x, x, field.u);
  std::vector<double> gradient(field.u.size(), 0.0);
  s.min_jacobian = d_.kernels->gradient(d_.view(), field.u.data(), gradient.data()).min_jacobian;
  double squares = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(3 * d_.free_nodes); ++i)
    squares += gradient[i] * gradient[i];
  s.force = -stiffness_ * x;
  s.stiffness = stiffness_;
  s.energy = 0.5 * x.dot(stiffness_ * x);
  s.residual = std::sqrt(squares) / std::max(s.force.norm(), d_.force_floor);
  s.iterations = 1;
  s.status = s.residual < 1e-8 ? SolveStatus::converged : SolveStatus::diverged;
  return s;
}

}  // namespace forefeel
