#include "scheduling/render/render_loop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scheduling/render/input_log.hpp"

namespace forefeel {

RenderLoop::RenderLoop(Device& device, LoopLink& link, const RenderOptions& options, std::size_t frames,
                       RealTime real)
    : device_(device),
      link_(link),
      switch_(options.switching),
      safety_(options.safety, options.frame),
      frame_(options.frame),
      frames_(frames),
      now_(std::move(real.now)),
      log_(frames + real.spare),
      jump_speed_(options.switching.jump_speed) {
  if (!options.viscosity.empty()) filter_.emplace(options.viscosity);
  if (options.passivity.mode != Passivity::control) return;
  control_.emplace(options.passivity, options.frame);
  without_.emplace(options.safety, options.frame);
  uncontrolled_log_.resize(log_.size());
}

void RenderLoop::frame(std::size_t k, double started) noexcept {
  const double before = hip_.t;
  const std::size_t step = next_ > 0 && k >= next_ ? k - next_ + 1 : 1, held = device_faults_.held;
  hip_ = next_hip(device_, hip_, k, frame_, sent_, device_faults_.held, step);
  count_jump();
  next_ = k + 1;
  const double t = hip_.t;
  const Vec3 x = hip_.at;
  link_.hip.publish(hip_);

  const std::uint32_t known = link_.known.load(std::memory_order_acquire);
  const Model* newest = link_.models.take().value_or(nullptr);
  const ForceSwitch::Frame f = switch_.step(newest, x);
  if (newest) {
    newest_ = static_cast<std::uint32_t>(newest->serial());
    newest_model_ = newest;
  }
  took_model_ = newest != nullptr;
  if (f.took_model) model_ = newest_;  // the switch may let it wait, and takes the latest
  give_back(f.released);
  give_back(f.released_too);
  input_ = {.frame = static_cast<std::uint32_t>(k),
            .known = known,
            .model = newest ? newest->serial() : 0,
            .ended = ended_,
            .held = device_faults_.held > held,
            .started = started,
            .at = x};
  const Vec3 rendered = filter_ ? filter_->step(f.force, t - before) : f.force;
  sent_ = send(rendered, started);
  input_.rendered = rendered;
  input_.sent = sent_;
  if (link_.inputs) link_.inputs->frame(input_);
  const ForceBar error_bar = bar(f);

  recorded_ = done_ < log_.size();
  if (recorded_) {
    if (control_) uncontrolled_log_[done_] = uncontrolled_;
    FrameRecord& record = log_[done_++];
    record.t = t;
    record.at = x;
    record.force = rendered;
    record.elastic = f.force;
    record.sent = sent_;
    record.undamped = f.undamped;
    record.bar = error_bar;
    record.model = model_;
    record.known = known;
    record.step.took_model = f.took_model;
    record.step.undamped_jump = f.undamped_jump;
    record.step.change = f.change.norm();
    record.step.delta = f.change;
    record.step.bound = f.bound;
    record.step.motion_change = (f.force - elastic_ - f.change).norm();
  }
  elastic_ = f.force;
}

void RenderLoop::count_jump() noexcept {
  if (next_ == 0) return;  // from rest to where the motion begins
  if (hip_.velocity.norm() > (1 + 1e-9) * jump_speed_) ++device_faults_.jumps;
}

// Tells the planner what is rendered here, so that it can be scored later.
ForceBar RenderLoop::bar(const ForceSwitch::Frame& frame) noexcept {
  if (const auto newer = link_.bars.take()) bar_ = *newer;
  const double scale = bar_.scale.at(hip_.at, frame.undamped);
  const double residual = (frame.force - frame.undamped).norm();
  link_.rendered.push({hip_.at, frame.force, scale, residual, bar_.label});
  ForceBar made{.scale = scale};
  for (std::size_t i = 0; i < made.half_width.size(); ++i)
    made.half_width[i] = std::hypot(bar_.factors[i] * scale, residual);
  return made;
}

Vec3 RenderLoop::send(const Vec3& rendered, double started) noexcept {
  const std::size_t left = frames_ - std::min(frames_, next_ - 1);  // this frame included
  const std::size_t needed = safety_.frames_to_zero();
  ending_ = ending_ || left <= needed + needed / 4 + 1;
  const double beat = link_.planner_beat.load(std::memory_order_relaxed);
  SafetyMoment moment{.t = hip_.t, .age = hip_.t - beat, .ending = ending_};
  input_.beat = beat;
  if (now_) {
    const double now = now_();
    input_.now = now;
    moment.age = now - beat;
    if (done_ > 0) moment.passed = std::min(started - started_, now - sent_at_);
    started_ = started;
    sent_at_ = now;
  }
  return control_ ? send_controlled(rendered, moment) : safety_.apply(rendered, hip_.at, moment);
}

Vec3 RenderLoop::send_controlled(const Vec3& rendered, SafetyMoment moment) noexcept {
  uncontrolled_ = without_->apply(rendered, hip_.at, moment);
  if (newest_model_ != nullptr && (took_model_ || control_->wants_model())) {
    Vec3 here;
    Mat3 jacobian;
    newest_model_->evaluate(hip_.at, here, jacobian);
    control_->note_model(hip_.at, {here, newest_model_->force(0.5 * hip_.at), jacobian}, took_model_);
  }
  moment.control = &*control_;
  return safety_.apply(rendered, hip_.at, moment);
}

void RenderLoop::note_timing(double cost_us, double lateness_us) noexcept {
  if (!recorded_) return;
  log_[done_ - 1].timing = {.cost_us = cost_us, .lateness_us = lateness_us};
}

void RenderLoop::give_back(const Model* model) noexcept {
  if (model && !link_.returned.push(model)) ++lost_models_;
}

std::vector<FrameRecord> RenderLoop::take_log() {
  log_.resize(done_);
  return std::move(log_);
}

std::vector<Vec3> RenderLoop::take_uncontrolled() {
  if (control_) uncontrolled_log_.resize(done_);
  return std::move(uncontrolled_log_);
}

}  // namespace forefeel
