#include "solver/kernels/kernels.hpp"

#include "geometry/common/instruction_set.hpp"

namespace forefeel {

FOREFEEL_IN_EACH_SET(extern const FrontKernels front_kernels;)

const FrontKernels& front_kernels() {
  return FOREFEEL_CHOSEN(front_kernels);
}

const char* instruction_set() {
  const InstructionSet set = instruction_set_in_use();
  return set == InstructionSet::avx512 ? "AVX-512" : set == InstructionSet::avx2 ? "AVX2" : "portable";
}

}  // namespace forefeel
