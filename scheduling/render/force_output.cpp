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

const Vec3& ForceOutput::send(const Vec3& rendered, const HipSample& tip, const LoopModels& models,
                              const Frame& frame) noexcept {
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
    note_model(tip.at, models);
    moment.control = &*control_;
  }
  sent_ = safety_.apply(rendered, tip.at, moment);
  return sent_;
}

void ForceOutput::note_model(const Vec3& x, const LoopModels& models) noexcept {
  const Model* newest = models.newest();
  if (newest == nullptr || !(models.came() || control_->wants_model())) return;
  Vec3 here;
  Mat3 jacobian;
  newest->evaluate(x, here, jacobian);
  control_->note_model(x, {here, newest->force(0.5 * x), jacobian}, models.came());
}

}  // namespace forefeel
