#pragma once
// Passes the answers that a rank receives to the function that is set. For any thread.

#include <functional>
#include <mutex>
#include <utility>

#include "geometry/common/packer.hpp"

namespace forefeel {

class RankListener {
 public:
  using Hear = std::function<void(Bytes)>;
  void set(Hear hear) {
    const std::lock_guard lock(mutex_);
    hear_ = std::move(hear);
  }
  void hear(Bytes answer) {
    const std::lock_guard lock(mutex_);
    if (hear_) hear_(std::move(answer));
  }

 private:
  std::mutex mutex_;
  Hear hear_;
};

}  // namespace forefeel
