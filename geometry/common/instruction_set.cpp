#include "geometry/common/instruction_set.hpp"

#include <algorithm>
#include <cstdlib>
#include <string>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

InstructionSet supported() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  const auto has = [](auto... present) { return (... && (present != 0)); };
  if (!has(__builtin_cpu_supports("avx2"), __builtin_cpu_supports("fma"), __builtin_cpu_supports("bmi2")))
    return InstructionSet::portable;
  if (!has(__builtin_cpu_supports("avx512f"), __builtin_cpu_supports("avx512dq"),
           __builtin_cpu_supports("avx512vl"), __builtin_cpu_supports("avx512bw"),
           __builtin_cpu_supports("avx512cd")))
    return InstructionSet::avx2;
  return InstructionSet::avx512;
#else
  return InstructionSet::portable;
#endif
}

InstructionSet choose() {
  InstructionSet set = supported();
  if (const char* asked = std::getenv("FOREFEEL_ISA"))
    for (const InstructionSet lower : {InstructionSet::portable, InstructionSet::avx2})
      if (name(lower) == asked) set = std::min(set, lower);
  return set;
}

}  // namespace

std::string_view name(InstructionSet set) {
  return set == InstructionSet::portable ? "portable" : set == InstructionSet::avx2 ? "avx2" : "avx512";
}

InstructionSet instruction_set_in_use() {
  static const InstructionSet chosen = choose();
  return chosen;
}

void check_instruction_set() {
  const char* asked = std::getenv("FOREFEEL_ISA");
  if (asked == nullptr || *asked == '\0') return;
  for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512})
    if (name(set) == asked) return;
  throw InputError("environment variable FOREFEEL_ISA",
                   "is '" + std::string(asked) + "', expected portable, avx2 or avx512, or unset");
}

}  // namespace forefeel
