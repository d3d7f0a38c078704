#pragma once
// The words by which scenes and the command line name the choices of a session.

#include <string>
#include <utility>
#include <vector>

#include "scheduling/session/session_options.hpp"

namespace forefeel {

template <class Choice>
using Words = std::vector<std::pair<std::string, Choice>>;

const Words<Clock>& clock_words();           // real, virtual
const Words<SessionMethod>& method_words();  // rbf, trilinear, tricubic
const Words<Placement>& placement_words();   // lattice, adaptive, path
const Words<Select>& select_words();         // label, nearest
const Words<SwitchRule>& switch_words();     // paper, smooth, none
const Words<Passivity>& passivity_words();   // observe, control

}  // namespace forefeel
