#pragma once
// Check solves measure the error of a finished set of states: forces solved at random places of the box, which do not
// become states of the set. A state file keeps them as the note "checks", one line "x,y,z,fx,fy,fz" for each [m, N].

#include <filesystem>
#include <span>
#include <vector>

#include "geometry/states/state.hpp"
#include "geometry/states/state_header.hpp"

namespace forefeel {

// Replaces the check solves of a state file by the usable ones of `checks`. The caller has opened the file for
// appending.
void keep_checks(const std::filesystem::path& file, std::span<const State> checks);
struct CheckSolves {
  std::vector<State> states;
  Box box = {};  // [m] they were drawn evenly from it
};
// Without states if there is no such note. InputError (key "notes") for a line that does not hold six finite numbers.
CheckSolves check_solves(const StateFileHeader& header);

}  // namespace forefeel
