#pragma once
// Bounded lock-free queue from one writer to one reader: a ring of Capacity - 1 usable places. Never
// allocates.

#include <array>
#include <atomic>
#include <cstddef>
#include <optional>

namespace forefeel {

template <class T, std::size_t Capacity>
class SpscQueue {
 public:
  // Writer. Returns false, and queues nothing, if the queue is full.
  bool push(const T& value) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    const std::size_t next = (tail + 1) % Capacity;
    if (next == head_.load(std::memory_order_acquire)) return false;
    ring_[tail] = value;
    tail_.store(next, std::memory_order_release);
    return true;
  }

  // Reader. Returns the oldest value; nullopt if empty.
  std::optional<T> pop() noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return std::nullopt;
    const T value = ring_[head];
    head_.store((head + 1) % Capacity, std::memory_order_release);
    return value;
  }

 private:
  std::array<T, Capacity> ring_{};
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
};

}  // namespace forefeel
