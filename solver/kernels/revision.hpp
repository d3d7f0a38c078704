#pragma once
// The revision of the solver: sources, compiler and flags of this build, and the instruction set of this
// machine. Two builds with the same revision give the same bits. Files of solutions kept for later runs have
// it in their names.

#include <string>

namespace forefeel {

std::string solver_revision();

}  // namespace forefeel
