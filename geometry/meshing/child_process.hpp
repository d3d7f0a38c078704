#pragma once
// Runs work that may crash, loop, or print, in a forked child process. The caller only sees the bytes that the
// work returns, or how the child ended. What the child prints is dropped. The child ends when its parent
// does. Private to this room.

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

namespace forefeel {

struct ChildLimits {
  std::chrono::steady_clock::time_point deadline;  // then the child is killed
  const std::atomic<bool>* stop = nullptr;         // once true, the child is killed
  std::function<void()> tick = {};                 // called by the waiting parent ten times in a second
};

struct ChildOutcome {
  enum class End { exited, signalled, late, stopped, not_begun };
  End end = End::not_begun;
  int code = 0;      // exited: exit code; signalled: number of the signal; not_begun: errno
  std::string data;  // what the work returned; complete only for exited with code 0
};

// Exit codes of the child that do not come from the work: it threw, or its answer could not be written whole.
constexpr int child_threw = 98, child_cut_short = 99;

// The child ends with the code that work() returns; work writes its answer with write_to.
ChildOutcome run_apart(const ChildLimits& limits, const std::function<int(int out)>& work);
bool write_to(int out, const void* data, std::size_t size);

}  // namespace forefeel
