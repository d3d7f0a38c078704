#pragma once
// The revision of the solver: sources, compiler and flags of this build, and the instruction set of this
// machine. Two builds with the same revision give the same bits. Cache files of solutions have the revision in their
// names.

#include <string>

namespace forefeel {

std::string solver_revision();

}  // namespace forefeel
