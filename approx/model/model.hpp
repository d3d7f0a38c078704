#pragma once
// RBF model of the force (paper Eq. 1, 2): per force component
//   f~(x) = p(x) + sum_i lambda_i phi(|x - x_i|),   [A P; P^T 0][lambda; c] = [f; 0],   A_ij = phi(|x_i -
//   x_j|)
// phi = r or r^3 with linear p, r^5 with quadratic p; with stiffness data each state also contributes three
// derivative functionals per component (Hermite). Coordinates are centred and scaled inside.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "approx/model/model_options.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

struct ModelData;  // model_data.hpp

// Immutable once published; a fixed capacity lets the planner refill a released one without allocating.
class Model {
 public:
  Model();  // f~ = 0 everywhere
  ~Model();
  Model(Model&&) noexcept;
  Model& operator=(Model&&) noexcept;

  Vec3 force(const Vec3& x) const noexcept;                                  // [N]; no allocation, no lock
  void evaluate(const Vec3& x, Vec3& force, Mat3& jacobian) const noexcept;  // jacobian_ij = df_i/dx_j [N/m]
  std::span<const StateId> states() const noexcept;                          // those it was made from
  Kernel kernel() const noexcept;                                            // after step-down,
  int degree() const noexcept;                                               // and that of p
  bool is_tangent() const noexcept;  // stepped down to the tangent (or held force) of the nearest state
  // No force of this model exceeds B = 1.25 (F + K D) [N]: F and K the largest force and stiffness among its
  // states, D the hold distance. f~ is the RBF sum inside the hull of the states and up to the trust distance
  // outside; from twice that on it is a tangent, which is held from D on (model_data.hpp).
  double force_bound() const noexcept;
  double trust_distance() const noexcept;     // [m]
  double hold_distance() const noexcept;      // [m]
  void reserve(const ModelOptions& options);  // what an updater with these options will need
  std::uint64_t serial() const noexcept;      // grows with every update of one updater; 0 for the empty model

  ModelData& impl() { return *impl_; }
  const ModelData& impl() const { return *impl_; }

 private:
  std::unique_ptr<ModelData> impl_;
};

}  // namespace forefeel
