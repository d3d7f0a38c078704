#pragma once
// Weights of places on the predicted path, for policies that sum needs along it.

#include "geometry/common/types.hpp"

namespace forefeel {

// A state requested now is known after T = solve [s], the time of a solve. Places that the hand reaches at about that
// time count most (t [s]: time until then). Places it passes earlier benefit less; places it reaches later can wait.
//   u = 1 / (1 + l^2) for l = (T - t) / T > 0, else 1 / (1 - l)     [1]
double urgency(double t, double solve);

// The share of a prediction's weight that its position keeps; the rest goes to its surroundings.
//   sure = 1 / (1 + (deviation / 2 h)^2)   for the spacing h [m]     [1]
double sureness(double deviation, double h);

// A hand that leaves the box is expected to turn back: a position predicted outside is mirrored at the faces of the
// box until it is inside.
Vec3 folded(const Vec3& x, const Box& box);

}  // namespace forefeel
