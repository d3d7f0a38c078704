#pragma once
// The functions that the file of each material law (solver/kernels/law_*.cpp) defines.

#include "solver/kernels/kernels.hpp"
#include "solver/kernels/law_list.hpp"

namespace forefeel {

const LawEntry& law_entry(Law law);           // as compiled for this processor
const LawEntry& portable_law_entry(Law law);  // as compiled for every processor: the same bits everywhere

}  // namespace forefeel
