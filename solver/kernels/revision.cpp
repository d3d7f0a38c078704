#include "solver/kernels/revision.hpp"

#include "solver/kernels/kernels.hpp"

namespace forefeel {

std::string solver_revision() {
  return std::string(FOREFEEL_SOLVER_SOURCES) + " " + instruction_set();
}

}  // namespace forefeel
