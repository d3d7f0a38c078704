#pragma once
// The older methods, for comparison. Each gives the force f~(x) [N] at x [m] from a fixed set of states (x_i,
// F_i).
//   trilinear     in cells of the lattice {k h}^3 with all eight corners (Matyska, Peterlik 2007); elsewhere
//                 the value at the nearest point of such a cell, or the force of the nearest state if nearer
//   tricubic      the same by cubic convolution, with quadratic ghost values beyond the border
//   deflection    force-deflection curves along directions from rest: linear in depth, extrapolated from the
//                 last two states, interpolated between the three nearest directions (Mahvash, Hayward 2004)
//   two_force     linear in position along the line through two states (Picinbono et al. 2002). A simulation
//                 uses the two that it computed last; here these are the two nearest states
//   offline_rbf   one RBF model of all states (Peterlik et al.)
//   rbf_network   r^3 and linear p by least squares, with fewer centres than states (De et al.)
// Every method is bounded by |f~(x)| <= max |F_i| + 2 S d(x) [N]; a larger force is scaled down to the bound. So even
// far from the states no method can damage a device. d(x) [m]: distance to the nearest state;
// S [N/m]: the largest known stiffness, or the largest secant |F_i - F_j| / |x_i - x_j| of a state and its nearest
// neighbour.

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "approx/model/force_model.hpp"
#include "approx/model/model_options.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

enum class Method { rbf, trilinear, tricubic, deflection, two_force, offline_rbf, rbf_network };
std::string_view name(Method method);
std::span<const Method> all_methods();

struct MethodOptions {
  ModelOptions model{};     // offline_rbf
  double spacing = 0.006;   // lattice methods [m]
  std::size_t centres = 0;  // of rbf_network; 0: see RbfNetwork::centres_of()
};

class Approximation final : public ForceModel {
 public:
  // Any method but rbf, whose neighbour set follows the HIP (ModelUpdater). Throws InputError if the states
  // do not suit the method.
  Approximation(Method method, std::span<const State> states, const MethodOptions& options);
  Vec3 force(const Vec3& x) const noexcept;
  Vec3 force(const Place& place) const noexcept override { return force(place.x); }
  Answer at(const Place& place) const noexcept override;  // with its bound; for offline_rbf that of the model

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;  // never changed, shared by copies
};

}  // namespace forefeel
