#pragma once
// From the rendered force to the one that is sent: the safety rules, with passivity control where it is wanted, by the
// wall time that has passed. Under control note_model() goes before send(), where wants_model() asks for it. Nothing
// here allocates, locks or throws.

#include <functional>
#include <optional>

#include "scheduling/common/session_result.hpp"
#include "scheduling/motion/hip_sample.hpp"
#include "scheduling/render/render_options.hpp"
#include "scheduling/render/safety.hpp"

namespace forefeel {

class ForceOutput {
 public:
  // now(): as RealTime::now (render_loop.hpp); empty: each frame takes place at its nominal time.
  ForceOutput(const RenderOptions& options, std::function<double()> now);

  struct Frame {
    double started = 0, beat = 0;  // of the frame, of the planner's last step [s]
    bool ending = false;           // the force goes to zero
  };
  // Once a frame; came: there is a new model.
  bool wants_model(bool came) noexcept { return control_ && (control_->wants_model() || came); }
  void note_model(const Vec3& tip, const ModelView& model, bool came) noexcept {
    control_->note_model(tip, model, came);
  }
  void rest_at(const Vec3& rest) noexcept {
    if (control_) control_->rest_at(rest);
  }
  // Returns the force for the device [N].
  const Vec3& send(const Vec3& rendered, const HipSample& tip, const Frame& frame) noexcept;

  const Vec3& sent() const { return sent_; }
  double sent_at() const { return sent_at_; }  // by now() [s]; 0 without it
  const Safety& safety() const { return safety_; }
  bool controlled() const { return control_.has_value(); }
  // Under control: the force that the other rules alone would have sent [N].
  const Vec3& uncontrolled() const { return uncontrolled_; }
  PassivityReport passivity() const { return control_ ? control_->report() : PassivityReport{}; }

 private:
  std::function<double()> now_;
  Safety safety_;
  std::optional<PassivityControl> control_;  // none: passivity is observed only
  // The same rules at the same positions without control, to measure the added error.
  std::optional<Safety> without_;
  Vec3 sent_ = Vec3::Zero(), uncontrolled_ = Vec3::Zero();
  bool begun_ = false;
  double started_ = 0, sent_at_ = 0;  // last frame, by now() [s]
};

}  // namespace forefeel
