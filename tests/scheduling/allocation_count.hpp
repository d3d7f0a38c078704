#pragma once
// Counts every heap allocation of the calling thread (malloc and everything built on it). It replaces the
// allocator, so it cannot count under a sanitizer, which has its own.

#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FOREFEEL_COUNTS_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define FOREFEEL_COUNTS_ALLOCATIONS 0
#endif
#endif
#ifndef FOREFEEL_COUNTS_ALLOCATIONS
#define FOREFEEL_COUNTS_ALLOCATIONS 1
#endif

namespace forefeel::test {

std::size_t allocations();  // of this thread so far; always 0 under a sanitizer

}  // namespace forefeel::test
