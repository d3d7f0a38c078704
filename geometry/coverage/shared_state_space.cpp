#include "geometry/coverage/shared_state_space.hpp"

#include <thread>

namespace forefeel {

SharedStateSpace::Visit::Visit(const SharedStateSpace& owner) : shared(owner) {
  for (;;) {
    side = shared.open_.load();
    shared.readers_[side].fetch_add(1);
    // The role may have changed before the count was seen: then the writer may already be in there.
    if (shared.open_.load() == side) return;
    shared.readers_[side].fetch_sub(1);
  }
}

void SharedStateSpace::wait_until_empty(std::size_t side) const {
  while (readers_[side].load() != 0) std::this_thread::yield();
}

StateSpace::Insertion SharedStateSpace::insert(const State& state) {
  const std::lock_guard lock(writing_);
  const std::size_t old = open_.load();
  wait_until_empty(1 - old);  // readers that came too late and are leaving
  const StateSpace::Insertion result = spaces_[1 - old].insert(state);
  open_.store(1 - old);
  wait_until_empty(old);
  spaces_[old].insert(state);
  return result;
}

}  // namespace forefeel
