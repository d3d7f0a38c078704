#pragma once
// Checks whether states without an identity belong to a body, by tight solves at a few of their positions, and at
// their sites where they have sites.
//   fits   |f - g| <= 1 % of max(|f|, |g|, F / 10)
// f: force of the state; g: force of the body at the same position; F: largest force of the states [N]. Solves of the
// same body on two computers differ by far less than 1 %; bodies of other stiffness, clamp or contact differ by more.

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

struct AskedPosition {
  Vec3 at, given;              // [m], [N]
  Vec3 site;                   // [m]; as that of State
  std::optional<Vec3> solved;  // [N]; none where the body has no equilibrium
  bool fits = false;
};

struct BodyAnswer {
  std::vector<AskedPosition> asked;
  // Position of the first state beyond `farthest`; nothing is solved then.
  std::optional<Vec3> too_far;
  std::size_t fitting() const;
  // All positions fit; the body may have no equilibrium at less than half of them.
  bool fits() const;
};

// farthest [m]: no state of the body can be farther from rest. At most 8 positions are solved, near and far from rest,
// on all sides, by one call of `solve`, which answers in their order.
using SolveStates = std::function<std::vector<State>(std::span<const State* const>)>;
BodyAnswer ask_body(std::span<const State> states, double farthest, const SolveStates& solve);

// "at 7 of 8 positions asked the forces differ: at (0, 0, -0.02) m they hold (0, 0, 1.3) N, the body gives …"
std::string in_words(const BodyAnswer& answer);

}  // namespace forefeel
