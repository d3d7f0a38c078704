#include "approx/loops/instruction_set.hpp"

#include <algorithm>
#include <cstdlib>
#include <string>

#include "approx/loops/dense_kernels.hpp"
#include "approx/loops/exact_sums.hpp"
#include "approx/loops/kernel_rows.hpp"
#include "approx/loops/kernel_sums.hpp"
#include "approx/loops/view_loops.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {

#define FOREFEEL_DECLARE_LOOPS(isa)      \
  namespace isa {                        \
  extern const dense::Loops dense_loops; \
  extern const rows::Loops row_loops;    \
  extern const sums::Loops sum_loops;    \
  extern const exact::Loops exact_loops; \
  extern const view::Loops view_loops;   \
  }
FOREFEEL_DECLARE_LOOPS(portable)
#ifdef FOREFEEL_MULTIVERSION
FOREFEEL_DECLARE_LOOPS(avx2)
FOREFEEL_DECLARE_LOOPS(avx512)
#endif

std::string_view name(InstructionSet set) {
  return set == InstructionSet::portable ? "portable" : set == InstructionSet::avx2 ? "avx2" : "avx512";
}

namespace {

InstructionSet supported() {
#ifdef FOREFEEL_MULTIVERSION
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

#ifdef FOREFEEL_MULTIVERSION
#define FOREFEEL_CHOSEN(loops)                                        \
  (approx_instruction_set() == InstructionSet::avx512 ? avx512::loops \
   : approx_instruction_set() == InstructionSet::avx2 ? avx2::loops   \
                                                      : portable::loops)
#else
#define FOREFEEL_CHOSEN(loops) portable::loops
#endif

}  // namespace

InstructionSet approx_instruction_set() {
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

const dense::Loops& dense::loops() {
  static const Loops& chosen = FOREFEEL_CHOSEN(dense_loops);
  return chosen;
}
const rows::Loops& rows::loops() {
  static const Loops& chosen = FOREFEEL_CHOSEN(row_loops);
  return chosen;
}
const exact::Loops& exact::loops() {
  static const Loops& chosen = FOREFEEL_CHOSEN(exact_loops);
  return chosen;
}
const view::Loops& view::loops() {
  static const Loops& chosen = FOREFEEL_CHOSEN(view_loops);
  return chosen;
}
const sums::Loops& sums::loops() {
  static const Loops chosen = [] {
    Loops all = FOREFEEL_CHOSEN(sum_loops);
#ifdef FOREFEEL_MULTIVERSION
    // Each state loads fifteen numbers for about thirty operations, so wider vectors gain nothing. With
    // stores between two sums they were up to half slower (25 states: 43 to 77 ns; AVX2: always 46).
    if (approx_instruction_set() == InstructionSet::avx512) {
      std::ranges::copy(avx2::sum_loops.quick[1], all.quick[1]);
      all.hermite = avx2::sum_loops.hermite;
    }
#endif
    return all;
  }();
  return chosen;
}

}  // namespace forefeel
