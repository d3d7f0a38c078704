#pragma once
// A state space that many threads query while one inserts. Two copies of the space, one open to readers: an insertion
// goes into the closed one, the copies change roles, and when the last reader has left the other, it goes there, too.
// Chosen over a lock (a reader would wait for a triangulation) and over snapshots (a copy of all cells per insertion):
// readers take two atomic additions and never wait; insertions cost twice, and the memory is double.

#include <array>
#include <atomic>
#include <mutex>
#include <utility>

#include "geometry/coverage/state_space.hpp"

namespace forefeel {

class SharedStateSpace {
 public:
  explicit SharedStateSpace(const StateSpaceOptions& options)
      : spaces_{StateSpace(options), StateSpace(options)} {}

  // Callers queue. On return every later read() sees the state. Waits for readers that are still in the old copy.
  StateSpace::Insertion insert(const State& state);

  // Calls ask(const StateSpace&) on a space that does not change meanwhile and returns what it returns. Not for
  // StateSpace::regions(), which works things out as it is asked: that belongs to one owner.
  template <class Ask>
  auto read(Ask&& ask) const {
    const Visit visit(*this);
    return std::forward<Ask>(ask)(spaces_[visit.side]);
  }

 private:
  struct Visit {
    explicit Visit(const SharedStateSpace& owner);
    ~Visit() { shared.readers_[side].fetch_sub(1); }
    Visit(const Visit&) = delete;
    Visit& operator=(const Visit&) = delete;
    const SharedStateSpace& shared;
    std::size_t side = 0;
  };
  void wait_until_empty(std::size_t side) const;

  std::array<StateSpace, 2> spaces_;
  std::atomic<std::size_t> open_{0};
  mutable std::array<std::atomic<int>, 2> readers_{};
  std::mutex writing_;
};

}  // namespace forefeel
