#include "solver/kernels/kernels.hpp"

namespace forefeel {

namespace portable {
extern const ElementKernels element_kernels[5];
extern const FrontKernels front_kernels;
}  // namespace portable
#ifdef FOREFEEL_MULTIVERSION
namespace avx2 {
extern const ElementKernels element_kernels[5];
extern const FrontKernels front_kernels;
}  // namespace avx2
namespace avx512 {
extern const ElementKernels element_kernels[5];
extern const FrontKernels front_kernels;
}  // namespace avx512
#endif

namespace {

enum class Isa { portable, avx2, avx512 };

Isa detect() {
#ifdef FOREFEEL_MULTIVERSION
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
    return Isa::avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return Isa::avx2;
#endif
  return Isa::portable;
}

const Isa isa = detect();

}  // namespace

const ElementKernels& element_kernels(int law) {
#ifdef FOREFEEL_MULTIVERSION
  if (isa == Isa::avx512) return avx512::element_kernels[law];
  if (isa == Isa::avx2) return avx2::element_kernels[law];
#endif
  return portable::element_kernels[law];
}

const FrontKernels& front_kernels() {
#ifdef FOREFEEL_MULTIVERSION
  if (isa == Isa::avx512) return avx512::front_kernels;
  if (isa == Isa::avx2) return avx2::front_kernels;
#endif
  return portable::front_kernels;
}

const char* instruction_set() {
  return isa == Isa::avx512 ? "AVX-512" : isa == Isa::avx2 ? "AVX2" : "portable";
}

}  // namespace forefeel
