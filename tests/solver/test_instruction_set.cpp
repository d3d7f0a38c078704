// FOREFEEL_ISA chooses the kernels of the solver, as it does the loops of approx.

#include "geometry/common/instruction_set.hpp"
#include "solver/body/law.hpp"
#include "solver/body/material.hpp"
#include "solver/kernels/kernels.hpp"
#include "tests/support/test.hpp"

TEST_CASE("with FOREFEEL_ISA=portable, the kernels in use are the portable ones", "[solver]") {
  // The set is chosen once, so another process looks at it.
  const std::string self = fs::read_symlink("/proc/self/exe").string();
  CHECK(std::system(("FOREFEEL_ISA=portable '" + self + "' '[portable-kernels]' >/dev/null").c_str()) == 0);
  if (instruction_set_in_use() == InstructionSet::portable) return;
  CHECK(std::system(("FOREFEEL_ISA= '" + self + "' '[portable-kernels]' >/dev/null").c_str()) != 0);
}

TEST_CASE("the kernels in use are portable", "[.][portable-kernels]") {
  CHECK(instruction_set_in_use() == InstructionSet::portable);
  CHECK(instruction_set() == std::string("portable"));
  for (const Law law : all_laws()) CHECK(&law_entry(law) == &portable_law_entry(law));
}
