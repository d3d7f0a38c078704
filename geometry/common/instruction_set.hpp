#pragma once
// The instruction set of the hot loops of solver and approx. They are compiled once per set; the best set that the
// processor supports is chosen at start. The environment variable FOREFEEL_ISA (portable, avx2 or avx512) selects a
// lower set, for measurements and tests. A higher set than the processor's is ignored, and so is any other value; a
// program calls check_instruction_set() at its start to report such a value.

#include <string_view>

namespace forefeel {

enum class InstructionSet { portable, avx2, avx512 };  // x86-64, x86-64-v3, x86-64-v4
std::string_view name(InstructionSet set);
InstructionSet instruction_set_in_use();
// Throws InputError if FOREFEEL_ISA is set to another value; empty counts as unset.
void check_instruction_set();

}  // namespace forefeel

// FOREFEEL_IN_EACH_SET(declarations): repeats them in the namespace of every set that is compiled.
// FOREFEEL_CHOSEN(name): what has this name in the namespace of the set in use.
#if defined(__x86_64__)
#define FOREFEEL_IN_EACH_SET(...) \
  namespace portable {            \
  __VA_ARGS__                     \
  }                               \
  namespace avx2 {                \
  __VA_ARGS__                     \
  }                               \
  namespace avx512 {              \
  __VA_ARGS__                     \
  }
#define FOREFEEL_CHOSEN(name)                                                                \
  (::forefeel::instruction_set_in_use() == ::forefeel::InstructionSet::avx512 ? avx512::name \
   : ::forefeel::instruction_set_in_use() == ::forefeel::InstructionSet::avx2 ? avx2::name   \
                                                                              : portable::name)
#else
#define FOREFEEL_IN_EACH_SET(...) \
  namespace portable {            \
  __VA_ARGS__                     \
  }
#define FOREFEEL_CHOSEN(name) portable::name
#endif
