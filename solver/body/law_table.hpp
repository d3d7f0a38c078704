#pragma once
// The table of the material laws (solver/kernels/law_*.cpp): their names and the functions that each file defines.

#include <string_view>
#include <vector>

#include "solver/kernels/law_list.hpp"

namespace forefeel {

std::string_view name(Law law);  // "neo-hookean", …
std::vector<Law> all_laws();     // in the order of solver/kernels/law_list.hpp

const LawEntry& law_entry(Law law);           // as compiled for this processor
const LawEntry& portable_law_entry(Law law);  // as compiled for every processor: the same bits everywhere

}  // namespace forefeel
