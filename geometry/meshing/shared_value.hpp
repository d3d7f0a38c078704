#pragma once
// A value in memory that a forked child process shares with its parent. Private to this room.

#include <sys/mman.h>

#include <new>
#include <type_traits>

namespace forefeel {

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
