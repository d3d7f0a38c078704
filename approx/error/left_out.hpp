#pragma once
// Chooses which known forces to hold out, so that their errors are those to expect at other places.
//
// Positions are held out in groups that lie as far from the rest, in distance and direction, as the wanted places from
// the states (measured/position_groups.hpp).
//
// An eighth of the groups, far from each other, is held out at a time. With more than 1500 states, one state
// of each box of neighbouring states is compared, and natural groups are held out if any fit; else groups of boxes; or,
// where boxes are too large, only some patches of the states are used, and a part of the inner half of each is held
// out.
//
// Most groups lie between other states, so they tell little about places outside the states. A place is outside if it
// lies beyond all states by more than h / 4 in one of 26 directions u (to faces, edges and corners of a cube):
//   b(x) = max over u of (u.x - max u.x_i),   outside: b(x) > h / 4,   h: the spacing [m]
// For each of these directions in which places are wanted, the outermost states (a cap) are held out: those with
//   u.x > max u.x_i - t,   t: median of b over the wanted places outside [m]
// t is doubled as long as all caps together have fewer than 20 states outside the others. A cap has at most half of the
// states. With more than 1500 states, only the 700 nearest to the outermost one are used.

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

// A place as seen from known states.
struct SeenPlace {
  double away = unknown;      // distance to the nearest state [m]
  double beyond = 0;          // b [m]; negative inside
  std::size_t direction = 0;  // that of b
  bool outside = false;
  Vec3 from = Vec3::Zero();  // the place less the nearest state [m]
  double doubt = unknown;    // deviation of the force there, by a process of the states [N]; NaN: no process
};

// Locates places relative to the states of a space, at least one. The space must stay as it is.
class PlaceLocator {
 public:
  static constexpr std::size_t directions = 26;
  explicit PlaceLocator(const StateSpace& space);
  SeenPlace operator()(const Vec3& x) const;

 private:
  const StateSpace* space_;
  std::array<double, directions> farthest_;  // max u.x_i [m]
};

// The known and the held-out states, and where each held-out position lies relative to the known states.
struct Trial {
  std::unique_ptr<StateSpace> known;
  std::vector<State> held;
  std::vector<SeenPlace> seen;
  bool cap = false;  // the outermost states in a direction are held out; in other trials, groups of positions
};

struct Trials {
  std::vector<Trial> each;
  std::size_t positions = 0, groups = 0;  // held out, over all trials; caps count as groups
  bool alike = true;  // they are no easier to predict than the wanted places: as far away, in such directions
};

// states: usable ones, one at each position. wanted: the places where the force is wanted, relative to the states;
// empty, or farther than any state is from the rest: not known. Returns no trials if there are fewer than 3 groups.
Trials leave_out(std::span<const State> states, std::span<const SeenPlace> wanted, double spacing);

// Number of wanted places that are farther from the states than any held-out position is from the known ones. Inside
// and outside are compared separately.
std::size_t count_beyond(std::span<const SeenPlace> held, std::span<const SeenPlace> wanted);

// Quantiles of the errors to expect at the wanted places. Each place contributes the errors of the 25 held-out
// positions whose distance to known states, or doubt if all have one, is nearest to its own (in rank). A place outside
// contributes the errors of the held-out positions outside whose b is nearest to its own: about half of them, at most
// 25. Without wanted places: the quantiles of all errors. NaN if no held-out position is similar to any wanted place.
// errors, held: #held-out positions.
std::vector<double> expected_quantiles(std::span<const double> errors, std::span<const SeenPlace> held,
                                       std::span<const SeenPlace> wanted, std::span<const double> shares);

}  // namespace forefeel
