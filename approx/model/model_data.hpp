#pragma once
// The data of a Model, and the bound on its force:
//   f~(x) = (1 - w) sat(raw) + w sat(T)     [N]
//   B     = 1.25 (F + K D)                  [N], F and K the largest force and stiffness among the states
// in scaled coordinates y = (x - centre) / scale, with
//   raw(y)  the RBF sum and its polynomial
//   T(x)    a tangent f_b + J_b sigma(x - x_b): weighted mean of the tangents of the states nearest to the
//           HIP
//   sigma   leaves a displacement up to D / 2 as it is and never exceeds the hold distance D [m]; beyond D
//           the force is held constant
//   E(y)    distance outside the hull of the states (of its 26 supporting planes)
//   w(E)    0 up to the trust distance, 1 from twice that on, three times differentiable. Across a gap (a bridge
//           between two known regions) it is (1 - beta) w(E of the nearer side) + beta w(E of both sides): a place
//           between the two sides changes gradually from extrapolation to interpolation
//   sat     leaves |f| <= B / 1.25 as it is and never exceeds B
// Everything is twice differentiable in x. Inside the hull f~ is the RBF sum itself.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "approx/loops/aligned.hpp"
#include "approx/loops/kernel_sums.hpp"
#include "approx/model/model_options.hpp"
#include "geometry/common/tolerance.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

class LatticeField;

struct ModelData {
  static constexpr double full_share = 0.8;  // share of the bound up to which a force is left as it is

  // raw(y), and the frame of y.
  struct RbfSum {
    const sums::Loops* loops = &sums::loops();
    Kernel kernel = Kernel::linear;
    bool hermite = false;
    int power = 0;  // k of phi = r^k; 0: no RBF part, the tangent alone
    int degree = 0;
    std::size_t padded = 0;  // centres, padded to a multiple of 8
    std::size_t stride = 0;
    AlignedArray data;  // see kernel_sums.hpp
    std::array<std::array<double, 4>, 10>
        polynomial{};                     // over 1 x y z xx yy zz xy xz yz, per component (and 0)
    Vec3 centre = Vec3::Zero();           // [m]
    double scale = 1, inverse_scale = 1;  // [m], [1/m]
    void raw(const double y[3], double f[3]) const noexcept;
    void raw(const double y[3], double f[3], double j[9]) const noexcept;  // j: df_c/dy_d
  };
  struct Tangent {
    Vec3 at = Vec3::Zero(), force = Vec3::Zero();  // x_b [m], f_b [N]
    Mat3 jacobian = Mat3::Zero();                  // J_b [N/m]
    double hold = 0;                               // D [m]
  };
  struct Hull {
    double inner_squared = -1;             // |y|^2 up to which E cannot exceed the trust distance
    std::array<double, 13> low{}, high{};  // supports along the 13 axes of the 26 planes
    void set(const double* px, const double* py, const double* pz, std::size_t n, double trusted);
    double outside(const double y[3], double gradient[3]) const noexcept;  // E and dE/dy
  };
  // Where the sum is used, and where the tangent: w(E).
  struct Domain {
    double trust = 0;   // in scaled coordinates
    double quick = -1;  // |y|^2 up to which f~ is the sum alone; negative: nowhere
    Hull hull, whole;   // of the states (in a gap: of the nearer side); of both sides
    double bridge = 0;  // beta: weight of `whole`
  };
  // What an evaluation reads if f~ is the sum alone, and the function that evaluates it; null: none.
  struct Fast {
    sums::Sum sum;
    sums::Quick function = nullptr;
  };

  // A blend of energy jets (jet_set.hpp). Beyond `hold` from `centre` the force is held constant.
  struct Jets {
    std::size_t blocks = 0;  // 0: the model is no blend of jets
    AlignedArray data;       // approx/loops/jet_sums.hpp
    Vec3 centre = Vec3::Zero();
    double trusted = 0, hold = 0;  // largest radius of a jet [m]; [m]
    Tolerance tolerance = {};      // of a trusted force
  };

  std::vector<StateId> states;
  Jets jets;  // if it has blocks, it is the model and the rest is not used
  RbfSum sum;
  Tangent tangent;
  Domain domain;
  Fast fast;
  std::shared_ptr<const LatticeField> lattice;  // if set, it is the model and the rest is not used
  bool known = false;                           // false: zero everywhere
  double bound = 0;                             // B [N]
  double largest_stiffness = 0;                 // K [N/m]
  std::uint64_t serial = 0;

  void reserve(const ModelOptions& options);
  void reserve(std::size_t states_wanted, bool with_stiffness);
  void clear();
  void prepare();  // sets `fast`; call it last
};

}  // namespace forefeel
