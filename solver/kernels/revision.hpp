#pragma once
// The revision of the solver: sources, compiler and flags of this build, and the instruction set of this
// machine. Two builds with the same revision give the same bits. Names of cache files of solutions contain the
// revision.

#include <string>

namespace forefeel {

std::string solver_revision();

}  // namespace forefeel
