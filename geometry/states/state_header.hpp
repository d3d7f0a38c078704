#pragma once
// What a state file holds beside its states: what they belong to, their spacing and box, notes.

#include <map>
#include <string>

#include "geometry/states/body_identity.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

struct StateFileHeader {
  BodyIdentity identity;
  double spacing = unknown;  // [m]
  Box box;
  std::map<std::string, std::string> notes;  // provenance, free text
};

}  // namespace forefeel
