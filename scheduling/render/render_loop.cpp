#include "scheduling/render/render_loop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scheduling/render/input_log.hpp"

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

RenderLoop::RenderLoop(Device& device, LoopLink& link, const RenderOptions& options, std::size_t frames,
                       RealTime real, std::unique_ptr<Contact> contact)
    : link_(link),
      tip_(device, options.frame, options.switching.jump_speed),
      contact_(contact ? std::move(contact) : std::make_unique<Grasp>(link, options.switching)),
      output_(options, std::move(real.now)),
      end_{.frames = frames},
      log_{.frames = std::vector<FrameRecord>(frames + real.spare), .uncontrolled = {}} {
  if (!options.viscosity.empty()) fresh_.emplace(options.viscosity);
  filter_ = fresh_;
  if (output_.controlled()) log_.uncontrolled.resize(log_.frames.size());
}

void RenderLoop::frame(std::size_t k, double started) noexcept {
  const double before = hip_.t;
  hip_ = tip_.read(k, sent());
  const std::uint32_t known = link_.known.load(std::memory_order_acquire);
  TouchRecord touch;
  const ForceSwitch::Step f = contact_->step(hip_, touch);
  hip_.site = touch.site;
  link_.hip.publish(hip_);
  input_ = {.frame = static_cast<std::uint32_t>(k),
            .known = known,
            .model = contact_->came() ? contact_->newest() : 0,
            .ended = end_.early,
            .held = tip_.held(),
            .started = started,
            .at = hip().at,
            .rendered = relaxed(f.force, hip_.t - before)};
  send(started);
  if (link_.inputs) link_.inputs->frame(input_);
  record(f, contact_->bar(f), touch);
  elastic_ = f.force;
}

Vec3 RenderLoop::relaxed(const Vec3& elastic, double dt) noexcept {
  if (!filter_) return elastic;
  if (contact_->begins()) filter_ = fresh_;
  return filter_->step(elastic, dt);
}

void RenderLoop::record(const ForceSwitch::Step& f, const ForceBar& bar, const TouchRecord& touch) noexcept {
  log_.has_last = log_.done < log_.frames.size();
  if (!log_.has_last) return;
  if (output_.controlled()) log_.uncontrolled[log_.done] = output_.uncontrolled();
  FrameRecord& record = log_.frames[log_.done++];
  record.t = hip().t;
  record.at = hip().at;
  record.force = input_.rendered;
  record.elastic = f.force;
  record.sent = sent();
  record.undamped = f.undamped;
  record.bar = bar;
  record.known = input_.known;
  record.touch = touch;
  record.step = {.model = contact_->rendered(),
                 .took_model = f.took_model,
                 .delta = f.change,
                 .change = f.change.norm(),
                 .bound = f.bound,
                 .motion_change = (f.force - elastic_ - f.change).norm(),
                 .undamped_jump = f.undamped_jump};
}

void RenderLoop::send(double started) noexcept {
  const std::size_t left = end_.frames - std::min(end_.frames, next() - 1);  // this frame included
  const std::size_t needed = safety().frames_to_zero();
  end_.ending = end_.ending || left <= needed + needed / 4 + 1;
  input_.beat = link_.planner_beat.load(std::memory_order_relaxed);
  output_.rest_at(contact_->rest());
  if (output_.wants_model(contact_->came()))
    if (ModelView view; contact_->view(view)) output_.note_model(hip_.at, view, contact_->came());
  input_.sent =
      output_.send(input_.rendered, hip(), {.started = started, .beat = input_.beat, .ending = end_.ending});
  input_.now = output_.sent_at();
}

void RenderLoop::note_timing(double cost_us, double lateness_us) noexcept {
  if (!log_.has_last) return;
  log_.frames[log_.done - 1].timing = {.cost_us = cost_us, .lateness_us = lateness_us};
}

std::vector<FrameRecord> RenderLoop::take_log() {
  log_.frames.resize(log_.done);
  return std::move(log_.frames);
}

std::vector<Vec3> RenderLoop::take_uncontrolled() {
  if (output_.controlled()) log_.uncontrolled.resize(log_.done);
  return std::move(log_.uncontrolled);
}

}  // namespace forefeel
