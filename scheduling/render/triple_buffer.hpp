#pragma once
// Passes the newest value from one writer to one reader without locks. There are three slots: the writer
// fills one, the reader keeps one, and the third holds the latest published value. Each side swaps its slot
// with the third by one atomic exchange. Wait-free on both sides, never blocks, never allocates (as long as
// T's assignment does not).

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

namespace forefeel {

template <class T>
class TripleBuffer {
 public:
  // Writer. Returns the previous value if the reader never took it; it belongs to the writer again.
  std::optional<T> publish(const T& value) noexcept {
    slots_[back_].value = value;
    const std::uint8_t old =
        middle_.exchange(static_cast<std::uint8_t>(back_ | fresh), std::memory_order_acq_rel);
    back_ = old & index;
    if (old & fresh) return slots_[back_].value;
    return std::nullopt;
  }

  // Reader. Returns the newest value published since the last take; nullopt if there is none.
  std::optional<T> take() noexcept {
    if (!(middle_.load(std::memory_order_relaxed) & fresh)) return std::nullopt;
    const std::uint8_t old = middle_.exchange(front_, std::memory_order_acq_rel);
    front_ = old & index;
    return slots_[front_].value;
  }

 private:
  static constexpr std::uint8_t index = 3, fresh = 4;
  struct alignas(64) Slot {
    T value{};
  };
  std::array<Slot, 3> slots_;
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t back_ = 0;   // the writer's own
  alignas(64) std::uint8_t front_ = 2;  // the reader's own
};

}  // namespace forefeel
