#pragma once
// body.accuracy = E: the least costly body whose discretisation error is at most E. Bodies are tried from the cheapest
// on: linear elements before quadratic ones, few elements of the fine body before many, and last quadratic elements
// alone, for slender bodies, whose fine body corrects the force to a few millimetres only. The error is measured one
// radius of the contact inward and to two sides (solver/equilibrium/mesh_error.hpp): with a fine body the upper end of
// its interval; without one 1.5 times the change by splitting each tetrahedron in eight. The choice is kept in the
// cache folder.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

struct AccuracyTrial {
  Element element = Element::linear;
  std::size_t elements = 0;  // 0: the mesh is given
  std::size_t fine = 0;      // elements of the fine body; 0: none
};

struct AccuracyChoice {
  double wanted = 0;  // E [1]
  AccuracyTrial taken;
  double error = unknown, high = unknown;  // of the body taken; unknown: nothing could be said
  double seconds = 0, ms_per_state = 0;    // that the search took, and of a solve
  bool reached = false;                    // high <= wanted
};

// Keys that the scene gives; they are not varied.
struct AccuracyGiven {
  std::optional<Element> element;
  std::optional<std::size_t> elements, fine;  // fine: 0 for false
  std::size_t mesh_tets = 0;  // of a given volume mesh, whose element and elements are not varied; else 0
};

std::vector<AccuracyTrial> accuracy_trials(const AccuracyGiven& given);

struct BodyMaker {
  std::function<Body(const AccuracyTrial&)> make;  // with its fine body
  std::function<Vec3(const Body&)> inward;         // the direction of pressing
};

// about: text that the choice depends on, beside E and the trials.
AccuracyChoice choose_accuracy(double wanted, std::span<const AccuracyTrial> trials, const std::string& about,
                               const BodyMaker& maker);

std::string in_words(const AccuracyTrial& trial);
std::string in_words(const AccuracyChoice& choice);

}  // namespace forefeel
