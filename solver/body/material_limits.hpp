#pragma once
// What a material may be. Softer than a foam of air, stiffer than a thousand diamonds: there, forces leave the
// range in which residuals can be judged, and a number in the wrong unit is more likely.

namespace forefeel {

inline constexpr double softest_young = 1e-3, stiffest_young = 1e15;  // E [Pa]

}  // namespace forefeel
