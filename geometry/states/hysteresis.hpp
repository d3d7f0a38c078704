#pragma once
// Loading and unloading in measured rows: does the force at a place depend on whether the tip moves against the force
// or with it? The order of the rows is that of time. Rows are first averaged to knots: a knot ends where the path is
// farther than 2 % of the usual distance from the middle of the rows, so that tremor is no motion.
//
// course    of knot k: against the force or with it, if the path goes on in its direction there and the angle between
//           motion and force is at most 60 degrees
// pair      a knot and the nearest place on a segment of the other course, at the distance d [m]
// Delta_k   force [N] along the force, against less with, at the place of knot k
// The loop's width is the mean of Delta. It is named where both courses show the same sign and
//   |mean| > 4 standard errors by the scatter between successive knots; of 8 strokes or more, by that between strokes
//            too
//   |mean| > 3 mean(S d), S [N/m]: stiffness along the path. So much may the force change between the places of a
//            pair; of n loops (two strokes each), n >= 4, by chance in each: over sqrt(n)
//   |mean| > 1 % of the force
// and at least a quarter of the knots that have a course are in pairs: a path that crosses itself is no loop.

#include <optional>
#include <span>
#include <string>

#include "geometry/states/state.hpp"

namespace forefeel {

struct Hysteresis {
  double width = 0;         // of the loop: mean difference of loading and unloading [N]
  double share = 0;         // of the force at the same places
  std::size_t strokes = 0;  // runs of knots of one course that were compared
};
// rows: in the order of time. O(n), and O(k^2) of at most some thousand knots.
std::optional<Hysteresis> hysteresis_of(std::span<const State> rows);

// One line; empty: none was found.
std::string hysteresis_in_words(std::span<const State> rows);

}  // namespace forefeel
