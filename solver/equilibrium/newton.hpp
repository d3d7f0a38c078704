#pragma once
// Newton's method for a static equilibrium with the contact held at x:
//   r_f(u) = 0,  u_c = x,     steps d = -H_ff^{-1} r_f
// r = dW/du [N], H = d2W/du2 [N/m]; f the free nodes, c the contact. A step is halved until J = det F > 0 (if
// the law needs that) and the energy or the residual falls. If H_ff is not positive definite, a multiple of
// the stiffness at rest is added to it. An iterate counts as converged only if H_ff is positive definite
// there: the equilibrium is stable.

#include <memory>
#include <stop_token>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/system/factorisation.hpp"

namespace forefeel {

struct NewtonReport {
  SolveStatus status = SolveStatus::stalled;
  int iterations = 0;
  double residual = 0;  // |r_f| / max(|f|, floor)
  double energy = 0;    // [J]
  double min_jacobian = 0;
  Vec3 force = Vec3::Zero();  // of the body on the HIP [N]
};

// Work space of one body for one thread.
class NewtonSolver {
 public:
  explicit NewtonSolver(std::shared_ptr<const Discretisation> discretisation,
                        Precision precision = Precision::exact);

  // u: in, a local vector with the contact at x; out, the equilibrium. On success factor() belongs to H(u). With
  // keep_factor it may belong to an earlier iterate; then the last step with it reduced the residual at least
  // fivefold.
  NewtonReport solve(std::vector<double>& u, double tolerance, int max_iterations,
                     const std::stop_token& stop, bool keep_factor = false);
  // V = du/dx and K at u from the factor, as in lane_solver.hpp. left: 0 if the factor belongs to H(u); else it belongs
  // to a tangent nearby, and left is the share of an error that remains after a step with it. False if that factor is
  // too far from H(u).
  bool condense(const std::vector<double>& u, double left, double* tangent, Mat3& stiffness);
  double contraction() const {
    return contraction_;
  }  // of the last steps with the factor; 0: it belongs to H(u)
  const Factorisation& factor() const { return factor_; }
  bool factorise(const std::vector<double>& u);  // factor of H(u); false unless positive definite
  // Factor of H(u), or of H(u) plus a multiple of the stiffness at rest that makes it positive definite.
  bool factorise_shifted(const std::vector<double>& u);

  const Discretisation& discretisation() const { return *d_; }

 private:
  void evaluate(const std::vector<double>& u, NewtonReport& report);
  bool line_search(std::vector<double>& u, NewtonReport& report);

  std::shared_ptr<const Discretisation> d_;
  Factorisation factor_;
  std::vector<double> gradient_, step_, trial_, trial_gradient_, blocks_, rest_blocks_, product_, lanes_;
  double shift_ = 0, contraction_ = 0;
};

// Single if, at rest, a step with a single-precision factor leaves at most a thousandth of an error. Very slender
// bodies, and bodies of materials of very different stiffness, need exact factors.
Precision fitting_precision(const std::shared_ptr<const Discretisation>& discretisation);

}  // namespace forefeel
