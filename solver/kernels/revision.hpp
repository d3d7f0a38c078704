#pragma once
// Which solver computed a value: sources, compiler and flags of this build, and the instruction set of this machine.
// Two builds with one revision give the same bits; what is kept on disk for later runs carries it in its name.

#include <string>

namespace forefeel {

std::string solver_revision();

}  // namespace forefeel
