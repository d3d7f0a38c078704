#include "scheduling/render/force_output.hpp"

#include <algorithm>
#include <utility>

namespace forefeel {

ForceOutput::ForceOutput(const RenderOptions& options, std::function<double()> now)
    : now_(std::move(now)), safety_(options.safety, options.frame) {
  if (options.passivity.mode != Passivity::control) return;
  control_.emplace(options.passivity, options.frame);
  without_.emplace(options.safety, options.frame);
}

const Vec3& ForceOutput::send(const Vec3& rendered, const HipSample& tip, const Frame& frame) noexcept {
  SafetyMoment moment{.t = tip.t, .age = tip.t - frame.beat, .ending = frame.ending};
  if (now_) {
    const double now = now_();
    moment.age = now - frame.beat;
    if (begun_) moment.passed = std::min(frame.started - started_, now - sent_at_);
    started_ = frame.started;
    sent_at_ = now;
  }
  begun_ = true;
  if (control_) {
    uncontrolled_ = without_->apply(rendered, tip.at, moment);
    moment.control = &*control_;
  }
  sent_ = safety_.apply(rendered, tip.at, moment);
  return sent_;
}

}  // namespace forefeel
