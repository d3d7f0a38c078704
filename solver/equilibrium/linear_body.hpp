#pragma once
// A linear body: u(x) = V x, f = -K x, W = x^T K x / 2 with V = -H_ff^{-1} H_fc: one factor and three solves are its
// whole state space. Each state's residual is evaluated, not assumed.

#include "solver/equilibrium/lane_solver.hpp"
#include "solver/equilibrium/newton.hpp"

namespace forefeel {

class LinearBody {
 public:
  LinearBody(const Discretisation& d, NewtonSolver& newton);  // d must outlive this
  State state(const Vec3& x, LocalField& field) const;

 private:
  const Discretisation& d_;
  std::vector<double> tangent_;
  Mat3 stiffness_ = Mat3::Zero();
  bool solvable_ = false;
};

}  // namespace forefeel
