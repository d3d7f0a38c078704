#pragma once
// Waits for references until a session that was interrupted has run out of patience, whether it was interrupted before
// or during a wait.

#include <chrono>
#include <optional>

#include "scheduling/judge/judging_options.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

class Patience {
 public:
  explicit Patience(const StopOptions& stop) : stop_(stop) {}

  // nullopt: not ready in time. interrupted: the session has ended early.
  std::optional<State> wait_for(const Vec3& at, ReferenceService& references, bool interrupted = false,
                                const SurfacePlace& site = {});

 private:
  using Time = std::chrono::steady_clock;
  StopOptions stop_;
  Time::time_point end_ = Time::time_point::max();
};

}  // namespace forefeel
