#pragma once
// Weights of places on the predicted path, for policies that sum needs along it.

#include <vector>

#include "scheduling/policy/policy.hpp"

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

// Weighs the places of the box by the time to reach each. path_share of all weight is on the predicted path: the result
// is the weight of a prediction, by its horizon [s]. Before the hand has moved there is no path, and all weight is on
// the box: the first states spread over it.
template <class Place>
auto weigh_box(const PlannerView& view, double solve, double path_share, std::vector<Place>& box) {
  const bool truth = !view.predicted.empty() && view.predicted.back().deviation == 0;
  if (!truth && view.space.empty() && !(view.hip.velocity.norm() > 0)) path_share = 0;
  double on_path = 0, in_box = 0;
  for (const Prediction& p : view.predicted) on_path += urgency(p.horizon, solve);
  for (Place& place : box) in_box += place.weight = urgency(time_to_reach(place.at, view), solve);
  for (Place& place : box) place.weight *= in_box > 0 ? (1 - path_share) / in_box : 0;
  return [=](double horizon) { return on_path > 0 ? path_share * urgency(horizon, solve) / on_path : 0; };
}

}  // namespace forefeel
