#pragma once
// Solves up to eight neighbouring states at once, in the lanes of vector instructions, with one factor M of a
// tangent H near them:
//   u <- u - M^{-1} r_f(u), accelerated by Anderson mixing (Walker, Ni 2011) over the last steps.
// Then V = du/dx is corrected once or more by M^{-1}. With rho = -(H [V; I])_f and delta = M^{-1} rho,
//   K = [V; I]^T H [V; I] - sym(rho^T delta)   [N/m], error of second order in that of V, times M's misfit
//   f = -(g_c + V^T r_f)                       [N], error of second order in that of u
// r_f: residual of the free nodes, g_c: row of the contact in dW/du. If the iteration of a state does not contract,
// or its stiffness does not settle, the caller must solve that state in another way.

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
  bool stiffness_settled = false;  // false: M fits too badly; K and V are not valid
  double contraction = 0;          // largest ratio of the residuals after and before a step; 0: no step
  int iterations = 0;
  double residual = 0, energy = 0, min_jacobian = 0;  // relative, [J], least det F
  Vec3 force = Vec3::Zero();                          // [N]
  Mat3 stiffness = Mat3::Zero();                      // [N/m]
};

class NewtonSolver;

namespace detail {
// K, V and the correction V^T r_f of the force, with a factor of H at `field` itself: for a state whose
// stiffness did not settle with a neighbour's factor. False if H is not positive definite there.
bool condense_alone(NewtonSolver& newton, LocalField& field, LaneResult& result);
void copy_result(const LaneResult& result, State& state);  // of a lane that converged
}  // namespace detail

class LaneSolver {
 public:
  explicit LaneSolver(std::shared_ptr<const Discretisation> discretisation);

  // fields: 1 to 8 predictions with the contact's rows of u at the states' positions; out: the equilibria of
  // those that converge. residual_tolerance: on |r_f| / max(|f|, floor). rounds: largest number of
  // corrections of V and K; after one, V is good enough for a prediction, but K has seldom settled.
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
  std::size_t size_;  // length of a local vector in lanes
  std::vector<double> u_, residual_, step_, tangent_, product_;
  static constexpr int depth_ = 3;                              // of the mixing
  std::array<std::vector<double>, depth_> step_change_, move_;  // of the last iterations
  std::vector<double> last_step_, last_move_;
};

}  // namespace forefeel
