#pragma once
// A linear body: with the contact held at x,
//   u(x) = V x [m]     f(x) = -K x [N]     W(x) = x^T K x / 2 [J]
//   V = -H_ff^{-1} H_fc     K = H_cc + H_cf V [N/m]
// so one factorisation gives every state (H = d2W/du2; f: free nodes, c: contact; see factorisation.hpp).

#include <memory>
#include <mutex>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/equilibrium/lane_solver.hpp"
#include "solver/equilibrium/newton.hpp"

namespace forefeel {

// For one thread. Evaluates the residual of each state.
class LinearBody {
 public:
  LinearBody(const Discretisation& d, NewtonSolver& newton);  // d must outlive this
  // The state at x [m]; `field` receives u and V. Diverged if H_ff is not positive definite or the residual
  // exceeds 1e-8.
  State state(const Vec3& x, LocalField& field) const;

 private:
  const Discretisation& d_;
  std::vector<double> tangent_;
  Mat3 stiffness_ = Mat3::Zero();
  bool solvable_ = false;
};

// For several threads. The first call solves three states, at distance h along each axis; superposition gives every
// other state. K is the stiffness of the three states, made symmetric.
class LinearBasis {
 public:
  LinearBasis(std::shared_ptr<const Body> body, double spacing);  // h [m], > 0
  // The state at x [m]. Its residual is the largest of the three; iterations and seconds are 0.
  State at(const Vec3& x, bool want_displacements);

 private:
  void solve();
  double min_jacobian(const Vec3& x) const;
  std::shared_ptr<const Body> body_;
  double spacing_;
  std::once_flag once_;
  SolveStatus status_ = SolveStatus::diverged;
  Mat3 stiffness_ = Mat3::Zero();
  std::vector<double> displacements_[3];  // du/dx_c, #V x 3 row by row
  std::shared_ptr<const Discretisation> d_;
  std::vector<double> local_[3];  // du/dx_c, local vectors
  double residual_ = 0;
};

// Null unless the body is linear.
std::shared_ptr<LinearBasis> linear_basis(const std::shared_ptr<const Body>& body, double spacing);

}  // namespace forefeel
