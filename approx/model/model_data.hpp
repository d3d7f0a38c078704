#pragma once
// What a Model holds, and how its force is bounded. In scaled coordinates y = (x - centre) / scale:
//   raw(y)    the RBF sum and its polynomial
//   T(x)      a tangent: f_b + J_b sigma(x - x_b), the weighted mean of the tangents of the states nearest
//   the HIP;
//             sigma keeps a displacement up to half the hold distance D and never exceeds D: a held force
//             beyond
//   E(y)      distance outside the hull of the states (of its 26 supporting planes)
//   w(E)      0 up to the trust distance, 1 from twice that on, three times differentiable
//             across a gap (1 - beta) w(E of the nearer side) + beta w(E of both), so that what lies between two
//             sides goes from extrapolation to interpolation gradually
//   f~(x) = (1 - w) sat(raw) + w sat(T),   sat keeps |f| <= B / 1.25 and never exceeds B
//   B = 1.25 (F + K D), F and K the largest force and stiffness among the states.
// Everything is twice differentiable in x; inside the hull f~ is the RBF sum itself.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "approx/loops/aligned.hpp"
#include "approx/loops/kernel_sums.hpp"
#include "approx/model/model_options.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

class LatticeField;

struct ModelData {
  static constexpr double full_share = 0.8;  // of the bound, up to which a force is left as it is
  const sums::Loops* loops = &sums::loops();
  std::vector<StateId> states;
  Kernel kernel = Kernel::linear;
  bool hermite = false;
  int power = 0;  // 0: no RBF part, the tangent alone
  int degree = 0;
  std::size_t padded = 0;  // centres, padded to a multiple of 8
  std::size_t stride = 0;
  AlignedArray data;  // see kernel_sums.hpp
  std::array<std::array<double, 4>, 10>
      polynomial{};  // over 1 x y z xx yy zz xy xz yz, per component (and 0)
  Vec3 centre = Vec3::Zero();
  double scale = 1, inverse_scale = 1;

  std::shared_ptr<const LatticeField>
      lattice;  // where it is set, it is the model and the rest counts nothing

  bool known = false;  // false: zero everywhere
  Vec3 tangent_at = Vec3::Zero(), tangent_force = Vec3::Zero();
  Mat3 tangent_jacobian = Mat3::Zero();
  double hold = 0;   // D [m]
  double trust = 0;  // in scaled coordinates
  struct Hull {
    double inner_squared = -1;             // |y|^2 up to which E cannot exceed the trust distance
    std::array<double, 13> low{}, high{};  // supports along the 13 axes of the 26 planes
    void set(const double* px, const double* py, const double* pz, std::size_t n, double trusted);
    double outside(const double y[3], double gradient[3]) const noexcept;  // E and dE/dy
  };
  double quick = -1;                // |y|^2 up to which f~ is the sum alone; < 0: nowhere
  Hull hull, whole;                 // of the states, in a gap those of the nearer side; of both
  double bridge = 0;                // beta: how much the second counts
  double bound = 0;                 // B [N]
  sums::Sum alone;                  // what an evaluation reads where f~ is the sum alone
  sums::Quick quick_sum = nullptr;  // and what evaluates it there; null: nowhere
  double largest_stiffness = 0;     // K [N/m]
  std::uint64_t serial = 0;

  void reserve(std::size_t states_wanted, bool with_stiffness);
  void clear();
  void prepare();  // alone and quick_sum, when all else is there
  void raw(const double y[3], double f[3]) const noexcept;
  void raw(const double y[3], double f[3], double j[9]) const noexcept;  // j: df_c/dy_d
};

}  // namespace forefeel
