#pragma once
// forefeel evaluate with points sx,sy,sz,x,y,z: forces at sites of a scene with contact.anywhere, from its field at
// rest and the jets and states of the file, which correct it (solver/jet/deep_states.hpp).

#include <string>

#include "apps/console/console.hpp"

namespace forefeel {

struct EvaluateSites {
  std::string states, points, scene, output;
};

bool has_site_columns(const std::string& points);  // false for a file that cannot be read
int evaluate_sites(const Globals& globals, const EvaluateSites& wanted);

}  // namespace forefeel
