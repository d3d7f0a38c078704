#pragma once
// Continuation: moves an equilibrium along a straight line of contact positions,
//   u <- u + V dx (prediction, V = du/dx), then Newton at x + dx (correction)
// A step whose correction fails is halved. x [m], u local vectors [m] (discretisation.hpp), K [N/m].

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <stop_token>
#include <utility>
#include <vector>

#include "solver/equilibrium/lane_solver.hpp"
#include "solver/equilibrium/newton.hpp"

namespace forefeel {

class Continuation {
 public:
  explicit Continuation(std::shared_ptr<const Discretisation> discretisation,
                        Precision precision = Precision::exact);

  void begin_at_rest();
  void begin_at(const Vec3& at, const LocalField& field);  // an empty tangent is computed when needed

  // Moves to x in equal steps of at most max_step [m] (0: one step). Ends at x, or at the last position that it
  // reached. If between > 0, all steps but the last are solved only to the tolerance `between`, and a factor is reused
  // while the iteration with it contracts.
  NewtonReport advance(const Vec3& x, double max_step, double tolerance, int max_iterations,
                       const std::stop_token& stop, double between = 0);

  // Calls progress(share of the way) after each step of advance().
  void watch(std::function<void(double)> progress) { progress_ = std::move(progress); }

  const Vec3& at() const { return at_; }
  int iterations() const { return iterations_; }  // since begin
  // Newton at x from the prediction u; keeps one factor while the iteration with it contracts.
  NewtonReport correct(const std::vector<double>& u, const Vec3& x, double tolerance, int max_iterations,
                       const std::stop_token& stop);

  // How far u is from smooth in the last two steps of advance(): the larger |u_b - u_a - (V_a + V_b) dx / 2| / |dx| of
  // the steps from a to b. It is of second order in the step if u is smooth, and large if a step ended on another
  // branch of equilibria.
  double kink() const { return std::max(kinks_[0], kinks_[1]); }

  const LocalField& field() const { return field_; }  // with its tangent after an advance that converged
  // The last iterate of a step that did not converge.
  const std::vector<double>& trial() const { return trial_; }
  // Provides a tangent at the starting point and a factor near it. False if that equilibrium is not stable.
  bool prepare();
  void forget_factor() { has_factor_ = false; }         // to be called after other use of newton()
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
  bool has_factor_ = false;  // newton_.factor() belongs to field_ or to a field near it
  int iterations_ = 0;
  std::array<double, 2> kinks_{};  // of the last step and the one before
  std::function<void(double)> progress_;
};

namespace detail {
// The prediction u + V move from the field's u and V, with the contact's rows set to x.
void predict(const LocalField& field, const Vec3& move, const Vec3& x, std::vector<double>& u);
}  // namespace detail

}  // namespace forefeel
