#pragma once
// The shape of the body between known states: displacements u [m] as a function of the HIP position x [m],
//   u~(x) = sum_i w_i u_i + V g,   V = du/dx at rest [1], u(0) = 0
// The weights w_i [1] and g [m] are the same for every node. They are those of an RBF interpolant through the
// states i, through rest and through the slope V at rest: with functionals l_a (values at x_i and at 0,
// derivatives at 0), kernel phi(r) = r^k and polynomials p,
//   [A P; P^T 0][w; v] = [l_a phi(|x - .|); p(x)],   A_ab = l_a l_b phi,   P_ab = l_a p_b
// k = 5 with quadratic p where the states determine it and no weights are large, else k = 3 with linear p, else
// the nearest state and the slope at rest: u~ = u_m + V (x - x_m). All three are exact at the states and where
// u is linear in x: nodes of the contact move by x, and the shape of a linear body is exact.
//   Wendland, Scattered Data Approximation, 2005, ch. 8 and 16 (values and derivatives).

#include <span>
#include <string_view>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

enum class ShapeOrder { slope, cubic, quintic };
std::string_view name(ShapeOrder order);

struct ShapeWeights {
  std::vector<double> of_states;  // w [1], in the order of the places
  Vec3 of_slope = Vec3::Zero();   // g [m]
  ShapeOrder order = ShapeOrder::slope;
};

// Largest sum |w_i| of an interpolation (states and rest). Beyond it, the next simpler interpolation is used.
inline constexpr double most_weight = 16;

// places: positions x_i of the states [m]: finite, distinct, none at rest. Cost: O(n^3); allocates.
ShapeWeights shape_weights(const Vec3& x, std::span<const Vec3> places);

}  // namespace forefeel
