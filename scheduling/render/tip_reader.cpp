#include "scheduling/render/tip_reader.hpp"

namespace forefeel {

const HipSample& TipReader::read(std::size_t k, const Vec3& sent) noexcept {
  const double t = frame_time(k, frame_);
  Vec3 x = device_.position(t, sent);
  held_ = !x.allFinite();
  if (held_) {
    x = tip_.at;
    ++faults_.held;
  }
  const std::size_t step = next_ > 0 && k >= next_ ? k - next_ + 1 : 1;
  const double passed = static_cast<double>(step) * frame_;
  tip_ = {.t = t, .at = x, .velocity = k == 0 ? Vec3::Zero() : Vec3((x - tip_.at) / passed)};
  // The first frame leads from rest to where the motion begins.
  if (next_ > 0 && tip_.velocity.norm() > (1 + 1e-9) * jump_speed_) ++faults_.jumps;
  next_ = k + 1;
  return tip_;
}

}  // namespace forefeel
