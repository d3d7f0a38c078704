#pragma once
// One frame of the haptic loop where a body is touched anywhere, the same under both clocks:
//   device -> tip -> touch (site, slip) -> newest model at (s, x) -> switch -> relaxation -> safety -> device (+ log)
// A viscous law's memory belongs to the touch: it begins anew with the next one. Outside the body the force is zero at
// once; the slew limit of the safety rules bounds what a hand feels of a touch that ends under force.

#include <functional>
#include <optional>

#include "approx/switch/force_switch.hpp"
#include "approx/switch/relaxation.hpp"
#include "scheduling/render/force_output.hpp"
#include "scheduling/render/render_options.hpp"
#include "scheduling/render/tip_reader.hpp"
#include "scheduling/touch/touch_link.hpp"
#include "scheduling/touch/touch_records.hpp"

namespace forefeel {

struct TouchLoopOptions {
  RenderOptions render;
  std::optional<double> friction;  // coefficient; nullopt: the tip sticks
};

class TouchLoop {
 public:
  // field: of this loop alone. All outlive the loop. now(): wall time since the session's start [s]; empty: each frame
  // takes place at its nominal time.
  TouchLoop(Device& device, FieldOfSites& field, TouchLink& link, const TouchLoopOptions& options,
            std::size_t frames, std::function<double()> now = {});

  // started: by now() [s]; without it not read.
  void frame(std::size_t k, double started);
  void end() noexcept { ending_ = true; }  // the force goes to zero from the next frame on
  bool finished() const noexcept {
    return output_.sent().isZero(0) && (ending_ || tip_.next() >= frames_) && tip_.next() > 0;
  }
  void note_timing(double cost_us, double lateness_us) noexcept;

  std::vector<TouchFrameRecord> take_log();  // of the frames done so far
  std::vector<Vec3> take_uncontrolled();     // as SafetyReport::uncontrolled
  const Safety& safety() const { return output_.safety(); }
  std::size_t unfelt() const { return unfelt_; }  // frames with the tip inside the body, but no touch
  PassivityReport passivity() const { return output_.passivity(); }
  const DeviceFaults& faults() const { return tip_.faults(); }
  const HipSample& tip() const { return tip_.tip(); }
  const Touch& touched() const { return touch_; }

 private:
  Vec3 rendered(const TouchFrame& frame, const TouchModel* came, double dt, TouchFrameRecord& record);
  void note_source(const TouchFrame& frame, TouchFrameRecord& record);
  void send(const TouchFrame& frame, bool came, double started, TouchFrameRecord& record);

  FieldOfSites& field_;
  TouchLink& link_;
  TouchLoopOptions options_;
  TipReader tip_;
  std::size_t frames_, frame_ = 0;
  bool ending_ = false;
  Touch touch_;
  const TouchModel* model_ = nullptr;
  ForceSwitch switch_;
  std::optional<RelaxationFilter> fresh_filter_, filter_;  // none: the body is elastic
  ForceOutput output_;
  Vec3 last_elastic_ = Vec3::Zero(), last_tip_ = Vec3::Zero();
  double last_t_ = 0;
  std::size_t ramp_ = 0;  // frames of the ramp at the end
  std::vector<TouchFrameRecord> log_;
  std::vector<Vec3> uncontrolled_;  // empty if passivity is observed only
  std::size_t done_ = 0, unfelt_ = 0;
};

}  // namespace forefeel
