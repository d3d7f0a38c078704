#pragma once
// Runs work that may crash, loop, or print, in a forked child process. The caller only sees the bytes that the
// work returns, or how the child ended. What the child prints is dropped. The child ends when its parent
// does. Private to this room.

#include <sys/mman.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <functional>
#include <new>
#include <string>
#include <type_traits>
#include <vector>

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

// Arrays of the answer, one after the other, and how the parent takes them back in that order.
template <class T>
bool write_to(int out, const std::vector<T>& values) {
  const std::uint64_t count = values.size();
  return write_to(out, &count, sizeof count) && write_to(out, values.data(), sizeof(T) * values.size());
}
class ChildAnswer {
 public:
  explicit ChildAnswer(const std::string& data) : at_(data.data()) {}
  void take(void* to, std::size_t size) { std::memcpy(to, at_, size), at_ += size; }
  template <class T>
  void take(std::vector<T>& values) {
    std::uint64_t count = 0;
    take(&count, sizeof count);
    values.resize(count);
    take(static_cast<void*>(values.data()), sizeof(T) * count);
  }

 private:
  const char* at_;
};

// A value in memory that the child shares with its parent.
template <class Value>
class SharedValue {
 public:
  static_assert(std::is_trivially_destructible_v<Value>);
  SharedValue()
      : at_(::mmap(nullptr, sizeof(Value), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (at_ == MAP_FAILED) throw std::bad_alloc();
    value_ = new (at_) Value;
  }
  ~SharedValue() { ::munmap(at_, sizeof(Value)); }
  SharedValue(const SharedValue&) = delete;
  SharedValue& operator=(const SharedValue&) = delete;
  Value& operator*() const { return *value_; }

 private:
  void* at_;
  Value* value_ = nullptr;
};

}  // namespace forefeel
