#pragma once
// Counts every heap allocation of the calling thread (malloc and what is built on it), where the allocator
// may be replaced: not under a sanitizer, which brings its own.

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

namespace forefeel::testing {

std::size_t allocations();  // of this thread so far; always 0 where they are not counted

}  // namespace forefeel::testing
