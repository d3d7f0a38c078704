#include "scheduling/render/frame_pacer.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {

std::int64_t FramePacer::due(std::size_t k) const noexcept {
  return std::llround(static_cast<double>(k) * frame_ * 1e9);
}

std::size_t FramePacer::begin(std::int64_t woke) noexcept {
  std::size_t k = next_;
  if (next_ > 0) {
    const double periods = std::max(0.0, static_cast<double>(woke) / (frame_ * 1e9));
    auto newest = static_cast<std::size_t>(periods);
    while (newest > 0 && due(newest) > woke) --newest;  // rounding
    if (due(newest + 1) <= woke) ++newest;
    const std::size_t last = std::max(next_, frames_ > 0 ? frames_ - 1 : 0);
    k = std::clamp(newest, next_, next_ < frames_ ? last : std::max(next_, newest));
    const double pause = static_cast<double>(woke - woke_) / 1e9;
    if (pause > longest_pause_) {
      longest_pause_ = pause;
      paused_at_ = static_cast<double>(woke_) / 1e9;
    }
  }
  if (next_ < frames_) skipped_ += k - next_;
  next_ = k + 1;
  woke_ = woke;
  return k;
}

}  // namespace forefeel
