#pragma once
// RBF model of the force f [N] at the HIP position x [m] (paper Eq. 1, 2), for each component
//   f~(x) = p(x) + sum_i lambda_i phi(|x - x_i|)
//   [A P; P^T 0][lambda; c] = [f; 0],   A_ij = phi(|x_i - x_j|)
// x_i: positions of the states; p: polynomial with coefficients c, P its terms at the x_i; phi = r or r^3
// with linear p, r^5 with quadratic p. With stiffness data each state adds three derivatives per component
// (Hermite, or gradient-enhanced, interpolation). Internally, coordinates are centred and scaled.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "approx/model/force_model.hpp"
#include "approx/model/model_options.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

class LatticeField;
struct ModelData;  // model_data.hpp

// Memory for one model, filled by RbfFit::write or set_lattice and then given to Model::assign.
class ModelDraft {
 public:
  ModelDraft();  // f~ = 0 everywhere
  ~ModelDraft();
  ModelDraft(ModelDraft&&) noexcept;
  ModelDraft& operator=(ModelDraft&&) noexcept;

  void reserve(const ModelOptions& options);  // what a model with these options needs
  void clear();                               // f~ = 0 everywhere; keeps the memory
  void set_lattice(std::shared_ptr<const LatticeField> field, std::span<const StateId> states);
  void forget_states();  // for a first guess: states() of the model is then empty
  ModelData& data() { return *data_; }

 private:
  friend class Model;
  std::unique_ptr<ModelData> data_;
};

// Never changed in part: a model is evaluated, or replaced as a whole by assign().
class Model final : public ForceModel {
 public:
  Model();  // f~ = 0 everywhere
  ~Model() override;
  Model(Model&&) noexcept;
  Model& operator=(Model&&) noexcept;

  Vec3 force(const Vec3& x) const noexcept;  // [N]; no allocation, no lock
  Vec3 force(const Place& place) const noexcept override { return force(place.x); }
  // Of a model of jets with their own estimate. They are trusted where those that make the force are within their trust
  // and the estimate is within ModelOptions::tolerance.
  Answer at(const Place& place) const noexcept override;
  void evaluate(const Vec3& x, Vec3& force, Mat3& jacobian) const noexcept;  // jacobian_ij = df_i/dx_j [N/m]
  std::span<const StateId> states() const noexcept;                          // the states it was made from
  Kernel kernel() const noexcept;                                            // after step-down
  int degree() const noexcept;                                               // of p, after step-down
  bool is_tangent() const noexcept;  // stepped down to the tangent (or held force) of the nearest state
  // No force of this model exceeds B = 1.25 (F + K D) [N]. F and K: largest force and stiffness among its states. D:
  // the hold distance, beyond which the force is held constant. f~ is the RBF sum inside the hull of the states and up
  // to the trust distance outside it; from twice the trust distance on it is a tangent (model_data.hpp).
  double force_bound() const noexcept;
  double trust_distance() const noexcept;  // [m]
  double hold_distance() const noexcept;   // [m]
  std::uint64_t serial() const noexcept;   // grows with every update of one updater; 0 for the empty model
  bool uses_stiffness() const noexcept;    // Hermite data, after step-down
  bool has_jets() const noexcept;          // a blend of energy jets (jet_set.hpp)

  // Becomes the model that the draft describes. The two exchange their memory, so that a released model is reused
  // without allocation. Afterwards the draft has the former content of this model.
  void assign(ModelDraft& draft, std::uint64_t serial) noexcept;
  void reserve(const ModelOptions& options);  // memory that assign() passes to the draft; f~ does not change
  const ModelData& data() const noexcept { return *data_; }  // to read; for benchmarks of the sums

 private:
  std::unique_ptr<ModelData> data_;
};

}  // namespace forefeel
