#pragma once
// The instruction set of the inner loops. They are compiled once per set; the best set that the processor supports is
// chosen at start. The environment variable FOREFEEL_ISA (portable, avx2 or avx512) selects a lower set, for
// measurements and tests. A higher set than the processor's is ignored. Any other value is ignored too; a program calls
// check_instruction_set() at its start to report it.

#include <string_view>

namespace forefeel {

enum class InstructionSet { portable, avx2, avx512 };  // x86-64, x86-64-v3, x86-64-v4
std::string_view name(InstructionSet set);
InstructionSet approx_instruction_set();
// Throws InputError if FOREFEEL_ISA is set to another value; empty counts as unset.
void check_instruction_set();

}  // namespace forefeel
