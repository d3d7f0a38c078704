#pragma once
// Solves up to eight neighbouring states at once, in the lanes of vector instructions, with one factor M of a
// tangent H near them:
//   u <- u - M^{-1} r_f(u), accelerated by Anderson mixing (Walker, Ni 2011) over the last steps.
// A step that makes neither the energy nor the residual smaller is halved. Where the iteration is slow and `newton` is
// given, M is refactored at the mean state.
// Then V = du/dx is corrected by conjugate gradients with M. With rho = -(H [V; I])_f and delta = M^{-1} rho,
//   K = [V; I]^T H [V; I] - sym(rho^T delta)   [N/m], error of second order in that of V, times M's misfit
//   f = -(g_c + V^T r_f)                       [N], error of second order in that of u
// r_f: residual of the free nodes, g_c: row of the contact in dW/du. If the iteration of a state does not contract, or
// its stiffness does not settle (converge), the caller must solve that state in another way.

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
  // those that converge. residual_tolerance: on |r_f| / max(|f|, floor). rounds: largest number of corrections of V and
  // K; after one, V is good enough for a prediction, but K has seldom settled. newton: makes new factors where the
  // iteration is slow (`factor` must be its own); null: `factor` is used to the end.
  void solve(const Factorisation& factor, std::vector<LocalField*>& fields, double residual_tolerance,
             std::array<LaneResult, lane_count>& results, int rounds = 10, NewtonSolver* newton = nullptr);

  // |r_f| / max(|f|, floor) of 1 to 8 predictions; infinite where the energy is.
  std::array<double, lane_count> residuals(const std::vector<LocalField*>& fields);

 private:
  using LaneMask = std::array<double, lane_count>;  // 1 or 0 by lane, or another value
  void load(const std::vector<LocalField*>& fields);
  std::vector<double> mean_of(const LaneMask& mask) const;
  static void scale_lanes(const LaneMask& factor, double* v, std::size_t size);
  bool condense_lanes(const double* z, int count, std::array<LaneResult, lane_count>& results,
                      std::array<LaneMask, 3>& square) const;
  bool iterate(const Factorisation& factor, NewtonSolver* newton, int count, double tolerance,
               std::array<LaneResult, lane_count>& results);
  struct LaneProgress {
    LaneMask active{}, retreat{}, moved{};  // takes a step, goes back, has taken a step
    LaneMask best{}, least_energy{};
    std::array<int, lane_count> iterations{}, retreats{}, stale{};
    bool slow = false;
    double worst = 0;  // residual
  };
  void judge(int count, double tolerance, int iteration, LaneProgress& at,
             std::array<LaneResult, lane_count>& results);
  static void replace_lanes(const LaneMask& mask, const std::vector<double>& from, std::vector<double>& to);
  void mix(int known, const LaneMask& active);
  void remember(int known, const LaneMask& moved);
  void finish(const Factorisation& factor, int count, int rounds,
              std::array<LaneResult, lane_count>& results);

  std::shared_ptr<const Discretisation> d_;
  std::size_t size_;  // length of a local vector in lanes
  std::vector<double> u_, residual_, step_, tangent_, product_;
  static constexpr std::size_t depth_ = 5;                             // of the mixing
  double* step_change(std::size_t i) { return &history_[i * size_]; }  // of the last iterations
  double* move(std::size_t i) { return &history_[(depth_ + i) * size_]; }
  std::vector<double> last_step_, last_move_;
  std::vector<double> history_;  // 2 depth_ vectors; then the nine of the conjugate gradients
};

}  // namespace forefeel
