#include "solver/kernels/kernels.hpp"

namespace forefeel {

namespace portable {
extern const FrontKernels front_kernels;
}  // namespace portable
#ifdef FOREFEEL_MULTIVERSION
namespace avx2 {
extern const FrontKernels front_kernels;
}  // namespace avx2
namespace avx512 {
extern const FrontKernels front_kernels;
}  // namespace avx512
#endif

namespace {

KernelIsa detect() {
#ifdef FOREFEEL_MULTIVERSION
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
    return KernelIsa::avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return KernelIsa::avx2;
#endif
  return KernelIsa::portable;
}

const KernelIsa isa = detect();

}  // namespace

KernelIsa kernel_isa() {
  return isa;
}

const FrontKernels& front_kernels() {
#ifdef FOREFEEL_MULTIVERSION
  if (isa == KernelIsa::avx512) return avx512::front_kernels;
  if (isa == KernelIsa::avx2) return avx2::front_kernels;
#endif
  return portable::front_kernels;
}

const char* instruction_set() {
  return isa == KernelIsa::avx512 ? "AVX-512" : isa == KernelIsa::avx2 ? "AVX2" : "portable";
}

}  // namespace forefeel
