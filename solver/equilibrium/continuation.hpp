#pragma once
// An equilibrium that is moved along: the contact goes straight from where it is to x, the tangent du/dx predicts,
// Newton corrects, and a step that fails is halved.

#include <algorithm>
#include <array>
#include <memory>
#include <stop_token>
#include <vector>

#include "solver/equilibrium/lane_solver.hpp"
#include "solver/equilibrium/newton.hpp"

namespace forefeel {

class Continuation {
 public:
  explicit Continuation(std::shared_ptr<const Discretisation> discretisation);

  void begin_at_rest();
  void begin_at(const Vec3& at, const LocalField& field);  // an empty tangent is worked out when needed

  // In steps of at most max_step (0: one). Ends at x, or where the last step that worked ended. With between > 0 the steps
  // on the way are solved to that tolerance only, and factors serve on while they contract.
  NewtonReport advance(const Vec3& x, double max_step, double tolerance, int max_iterations,
                       const std::stop_token& stop, double between = 0);

  const Vec3& at() const { return at_; }
  int iterations() const { return iterations_; }  // since begin
  // Newton at x from the prediction u, on one factor where that contracts.
  NewtonReport correct(const std::vector<double>& u, const Vec3& x, double tolerance, int max_iterations,
                       const std::stop_token& stop);

  // How far the last two steps of advance are from smooth: the larger |u_b - u_a - (V_a + V_b) move / 2| / |move|, of second
  // order in the step where u is smooth, of the size of the jump over the step where it came out on another branch.
  double kink() const { return std::max(kinks_[0], kinks_[1]); }

  const LocalField& field() const { return field_; }  // with its tangent after an advance that converged
  // The iterate that the last step ended with, where it did not converge.
  const std::vector<double>& trial() const { return trial_; }
  // Makes sure of a tangent at the point begun at, and of a factor near it; false where it is not stable.
  bool prepare();
  void forget_factor() { has_factor_ = false; }         // newton()'s was used elsewhere
  const Mat3& stiffness() const { return stiffness_; }  // after an advance or a correction that converged
  NewtonSolver& newton() { return newton_; }

 private:
  bool take_tangent();
  NewtonReport correct_trial(const Vec3& x, double tolerance, int max_iterations, const std::stop_token& stop,
                             bool keep_factor);
  NewtonReport step_to(const Vec3& x, double tolerance, int max_iterations, const std::stop_token& stop,
                       bool keep_factor);

  std::shared_ptr<const Discretisation> d_;
  NewtonSolver newton_;
  LocalField field_;
  std::vector<double> trial_, half_;
  Vec3 at_ = Vec3::Zero();
  Mat3 stiffness_ = Mat3::Zero();
  bool has_tangent_ = false;
  bool has_factor_ = false;  // of, or near, field_
  int iterations_ = 0;
  std::array<double, 2> kinks_{};  // of the last step and the one before
};

namespace detail {
// The prediction u + V move from the field's u and V, with the contact's rows set to x.
void predict(const Discretisation& d, const LocalField& field, const Vec3& move, const Vec3& x,
             std::vector<double>& u);
}  // namespace detail

}  // namespace forefeel
