#pragma once
// Which compilation of the inner loops runs. They are compiled once per set and chosen at start, so that one
// binary serves old and new processors. The environment variable FOREFEEL_ISA (portable, avx2 or avx512) asks
// for a lower set than the processor has, to measure or to test it; a higher one is not granted, and anything else
// counts as unset here: check_instruction_set() is for a program's start.

#include <string_view>

namespace forefeel {

enum class InstructionSet { portable, avx2, avx512 };  // x86-64, x86-64-v3, x86-64-v4
std::string_view name(InstructionSet set);
InstructionSet approx_instruction_set();
// InputError where FOREFEEL_ISA is set to none of the names; empty counts as unset.
void check_instruction_set();

}  // namespace forefeel
