#pragma once
// The thread of a real-time loop: its priority, its stack and its clock. The session's loop and the bare loop to which
// it is compared (bare_loop.hpp) share these settings.

#include <cstdint>
#include <string>

namespace forefeel {

// CLOCK_MONOTONIC [ns]. Neither allocates nor throws.
std::int64_t monotonic() noexcept;
// Returns at the absolute time t of that clock [ns] or later.
void sleep_until(std::int64_t t) noexcept;

// Gives the calling thread real-time priority (SCHED_FIFO, 80) and touches 64 kB of its stack, so that a loop causes no
// page fault there. If the priority is refused, returns why; else an empty text.
std::string become_loop_thread();
// Lets the calling thread run only on processors that are otherwise idle (SCHED_IDLE).
void become_idle_thread() noexcept;

}  // namespace forefeel
