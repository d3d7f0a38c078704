#pragma once
// Recovers the polynomials E_4(d), E_5(d) (degrees 4 and 5 in d, 15 and 21 coefficients) from their values at 21 fixed
// directions: the axes, (1, +-0.6) and (0.6, +-1)-like pairs in the coordinate planes, and six inside. The matrices are
// constant; for values at the unit directions their condition numbers are below 40.

#include <array>
#include <span>

#include "geometry/common/types.hpp"
#include "geometry/states/energy_jet.hpp"

namespace forefeel {

inline constexpr std::size_t path_direction_count = 21;

const std::array<double, 3 * path_direction_count>& path_directions();  // row by row
const std::array<double, path_direction_count>& path_lengths();
// Products d_i d_j of a direction, pairs 11, 22, 33, 12, 13, 23.
std::array<double, 6> pair_products(const double* direction);

// Coefficients of degree 4 (least squares) and 5 into the jet.
void set_fourth(std::span<const double, path_direction_count> values, EnergyJet& jet);
void set_fifth(std::span<const double, path_direction_count> values, EnergyJet& jet);
double path_condition();  // the larger of the two condition numbers, for values at the unit directions

}  // namespace forefeel
