#pragma once
// Passes the answers that a rank receives to the function that is set. For any thread.

#include <functional>
#include <mutex>
#include <utility>

#include "geometry/common/packer.hpp"

namespace forefeel {

class RankListener {
 public:
  using Receive = std::function<void(Bytes)>;
  void set(Receive receive) {
    const std::lock_guard lock(mutex_);
    receive_ = std::move(receive);
  }
  void receive(Bytes answer) {
    const std::lock_guard lock(mutex_);
    if (receive_) receive_(std::move(answer));
  }

 private:
  std::mutex mutex_;
  Receive receive_;
};

}  // namespace forefeel
