// The loops of the instruction set in use.

#include <algorithm>

#include "approx/loops/dense_kernels.hpp"
#include "approx/loops/exact_sums.hpp"
#include "approx/loops/jet_sums.hpp"
#include "approx/loops/kernel_rows.hpp"
#include "approx/loops/kernel_sums.hpp"
#include "approx/loops/view_loops.hpp"
#include "geometry/common/instruction_set.hpp"

namespace forefeel {

FOREFEEL_IN_EACH_SET(extern const dense::Loops dense_loops; extern const rows::Loops row_loops;
                     extern const sums::Loops sum_loops; extern const exact::Loops exact_loops;
                     extern const view::Loops view_loops; extern const jets::Loops jet_loops;)

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
const jets::Loops& jets::loops() {
  static const Loops& chosen = FOREFEEL_CHOSEN(jet_loops);
  return chosen;
}
const sums::Loops& sums::loops() {
  static const Loops chosen = [] {
    Loops all = FOREFEEL_CHOSEN(sum_loops);
#if defined(__x86_64__)
    // Each state loads fifteen numbers for about thirty operations, so wider vectors gain nothing. With
    // stores between two sums they were up to half slower (25 states: 43 to 77 ns; AVX2: always 46).
    if (instruction_set_in_use() == InstructionSet::avx512) {
      std::ranges::copy(avx2::sum_loops.quick[1], all.quick[1]);
      all.hermite = avx2::sum_loops.hermite;
    }
#endif
    return all;
  }();
  return chosen;
}

}  // namespace forefeel
