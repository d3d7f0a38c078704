#pragma once
// Up to eight neighbouring states at once, in the lanes of vector instructions, on one factor M of H near them:
//   u <- u - M^{-1} r_f(u), accelerated by Anderson mixing (Walker, Ni 2011) over the last steps,
// then for each state, with V = du/dx corrected once or more by M^{-1} and rho = -(H [V; I])_f, delta = M^{-1} rho,
//   K = [V; I]^T H [V; I] - sym(rho^T delta)      second order in what V lacks, times how well M fits
//   f = -(g_c + V^T r_f)                          second order in what u lacks
// A state whose iteration does not contract is left to the caller, and so is one whose stiffness does not settle.

#include <array>
#include <memory>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/system/factorisation.hpp"

namespace forefeel {

// u (a local vector) and V = du/dx (three local vectors, one after the other) of one state.
struct LocalField {
  std::vector<double> u, tangent;
};

struct LaneResult {
  bool converged = false;
  bool stiffness_settled = false;  // false: M fits too badly for K and V, which then hold nothing
  double contraction = 0;  // the worst share of a residual that a step left; 0 where there was no step
  int iterations = 0;
  double residual = 0, energy = 0, min_jacobian = 0;
  Vec3 force = Vec3::Zero();
  Mat3 stiffness = Mat3::Zero();
};

class NewtonSolver;

namespace detail {
// K, V and the correction V^T r_f of the force, with a factor of H at `field` itself: for a state whose stiffness did not
// settle with a neighbour's factor. False if H is not positive definite there.
bool condense_alone(NewtonSolver& newton, LocalField& field, LaneResult& result);
void copy_result(const LaneResult& result, State& state);  // of a lane that converged
}  // namespace detail

class LaneSolver {
 public:
  explicit LaneSolver(std::shared_ptr<const Discretisation> discretisation);

  // fields: 1 to 8 predictions, the contact's rows of u at the states' positions; those that converge are replaced by
  // the equilibria. residual_tolerance: |r_f| / max(|f|, floor). rounds: corrections of V and K at most; with one, V is
  // good for a prediction and K seldom settled.
  void solve(const Factorisation& factor, std::vector<LocalField*>& fields, double residual_tolerance,
             std::array<LaneResult, lane_count>& results, int rounds = 3);

 private:
  void load(const std::vector<LocalField*>& fields);
  bool iterate(const Factorisation& factor, int count, double tolerance,
               std::array<LaneResult, lane_count>& results);
  void mix(int known, const std::array<double, lane_count>& active);
  void remember(int known);
  void finish(const Factorisation& factor, int count, int rounds,
              std::array<LaneResult, lane_count>& results);

  std::shared_ptr<const Discretisation> d_;
  std::size_t size_;  // of a local vector in lanes
  std::vector<double> u_, residual_, step_, tangent_, product_;
  static constexpr int depth_ = 3;                              // of the mixing
  std::array<std::vector<double>, depth_> step_change_, move_;  // of the last iterations
  std::vector<double> last_step_, last_move_;
};

}  // namespace forefeel
