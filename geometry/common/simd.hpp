#pragma once
// Macros for loops that are compiled for several instruction sets. No functions: what is compiled for a newer set must
// not be shared with other files.

#define FOREFEEL_INLINE inline __attribute__((always_inline))

// FOREFEEL_CLONES before a function compiles it for SSE2, AVX2 with FMA, and AVX-512. The loader picks one,
// so one binary serves old and new processors; FOREFEEL_ISA has no effect on it. Only for innermost loops over raw
// pointers: all functions that they call must be inlined. A single version is compiled with FOREFEEL_NATIVE, under a
// sanitizer (the resolvers run before its runtime) and with other compilers than GCC.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(FOREFEEL_NATIVE) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FOREFEEL_CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define FOREFEEL_CLONES
#endif
