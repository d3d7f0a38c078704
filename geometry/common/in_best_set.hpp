#pragma once
// Runs an innermost loop as compiled for the instruction set in use (instruction_set.hpp): one binary serves old and
// new processors.
//
//   namespace { FOREFEEL_INLINE double sum(std::size_t n, const double* x) { … } }
//   in_best_set<sum>(n, x);
//
// The loop belongs in an unnamed namespace, takes numbers and raw pointers, and calls only functions that are inlined:
// what is compiled for a newer set must not be shared with other files. With FOREFEEL_NATIVE, and with other compilers
// than GCC, there is one version.

#include "geometry/common/instruction_set.hpp"
#include "geometry/common/simd.hpp"

namespace forefeel {

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(FOREFEEL_NATIVE)
template <auto loop, class... Values>
__attribute__((target("arch=x86-64-v3"))) auto in_avx2(Values... values) {
  return loop(values...);
}
template <auto loop, class... Values>
__attribute__((target("arch=x86-64-v4"))) auto in_avx512(Values... values) {
  return loop(values...);
}
template <auto loop, class... Values>
auto in_portable(Values... values) {
  return loop(values...);
}

template <auto loop, class... Values>
auto in_best_set(Values... values) {
  static auto* const chosen = instruction_set_in_use() == InstructionSet::avx512 ? in_avx512<loop, Values...>
                              : instruction_set_in_use() == InstructionSet::avx2
                                  ? in_avx2<loop, Values...>
                                  : in_portable<loop, Values...>;
  return chosen(values...);
}
#else
template <auto loop, class... Values>
auto in_best_set(Values... values) {
  return loop(values...);
}
#endif

}  // namespace forefeel
