#include "scheduling/render/render_loop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scheduling/render/input_log.hpp"

namespace forefeel {

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
  const ForceSwitch::Frame f = contact_->step(hip_, touch);
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

void RenderLoop::record(const ForceSwitch::Frame& f, const ForceBar& bar, const TouchRecord& touch) noexcept {
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
