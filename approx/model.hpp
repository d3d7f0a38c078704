#pragma once
// RBF model of the force (paper Eq. 1, 2): per force component
//   f~(x) = p(x) + sum_i lambda_i phi(|x - x_i|),   [A P; P^T 0][lambda; c] = [f; 0],   A_ij = phi(|x_i - x_j|)
// phi = r or r^3 with linear p, r^5 with quadratic p; with stiffness data each state also contributes three
// derivative functionals per component (Hermite). Coordinates are centred and scaled inside.

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "geometry/state_space.hpp"

namespace forefeel {

enum class Kernel { linear, cubic, quintic };
enum class Data { force, force_and_stiffness };
enum class Select { label, nearest };
std::string_view name(Kernel kernel);
std::string_view name(Data data);       // "force", "force+stiffness"
std::string_view name(Select select);

struct ModelOptions {
  Kernel kernel = Kernel::cubic;
  Data data = Data::force;
  std::size_t neighbours = 100;          // n
  Select select = Select::label;
  double ridge = 0;                      // >= 0, added to the kernel's diagonal, for noisy states
};

// Immutable once published; a fixed capacity lets the planner refill a released one without allocating.
class Model {
 public:
  Model();                               // f~ = 0 everywhere
  ~Model();
  Model(Model&&) noexcept;
  Model& operator=(Model&&) noexcept;

  Vec3 force(const Vec3& x) const noexcept;                                   // [N]; no allocation, no lock
  void evaluate(const Vec3& x, Vec3& force, Mat3& jacobian) const noexcept;   // jacobian_ij = df_i/dx_j [N/m]
  std::span<const StateId> states() const noexcept;                           // those it was made from
  Kernel kernel() const noexcept;        // after step-down
  bool is_tangent() const noexcept;      // stepped down to the tangent (or held force) of the nearest state
  double force_bound() const noexcept;   // no force of this model exceeds it [N]
  std::uint64_t serial() const noexcept; // grows with every update of one updater; 0 for the empty model

  struct Impl;
  Impl& impl() { return *impl_; }
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
