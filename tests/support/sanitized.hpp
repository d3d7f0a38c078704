#pragma once

namespace forefeel::test {

// Whether this build runs under the address or thread sanitizer. Both reserve the whole address space, so that its size
// cannot be limited (ulimit -v).
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool sanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif
#else
constexpr bool sanitized = false;
#endif

}  // namespace forefeel::test
