#pragma once
// Accepted range of Young's modulus. Outside it, forces leave the range in which residuals can be judged, and a value
// in the wrong unit is the likely cause. (The limits are far beyond any foam and a thousand times diamond.)

namespace forefeel {

inline constexpr double softest_young = 1e-3, stiffest_young = 1e15;  // E [Pa]

}  // namespace forefeel
