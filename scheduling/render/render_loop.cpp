#include "scheduling/render/render_loop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scheduling/render/input_log.hpp"

namespace forefeel {

RenderLoop::RenderLoop(Device& device, LoopLink& link, const RenderOptions& options, std::size_t frames,
                       RealTime real)
    : link_(link),
      tip_(device, options.frame, options.switching.jump_speed),
      models_(link, options.switching),
      jnd_(options.switching),
      output_(options, std::move(real.now)),
      end_{.frames = frames},
      log_{.frames = std::vector<FrameRecord>(frames + real.spare), .uncontrolled = {}} {
  if (!options.viscosity.empty()) filter_.emplace(options.viscosity);
  if (output_.controlled()) log_.uncontrolled.resize(log_.frames.size());
}

void RenderLoop::frame(std::size_t k, double started) noexcept {
  const double before = hip().t;
  tip_.read(k, sent());
  link_.hip.publish(hip());

  const std::uint32_t known = link_.known.load(std::memory_order_acquire);
  const ForceSwitch::Frame f = models_.step(hip().at);
  input_ = {.frame = static_cast<std::uint32_t>(k),
            .known = known,
            .model = models_.came() ? models_.newest()->serial() : 0,
            .ended = end_.early,
            .held = tip_.held(),
            .started = started,
            .at = hip().at,
            .rendered = filter_ ? filter_->step(f.force, hip().t - before) : f.force};
  send(started);
  if (link_.inputs) link_.inputs->frame(input_);
  record(f, bar(f));
  elastic_ = f.force;
}

void RenderLoop::record(const ForceSwitch::Frame& f, const ForceBar& bar) noexcept {
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
  record.step = {.model = models_.rendered(),
                 .took_model = f.took_model,
                 .delta = f.change,
                 .change = f.change.norm(),
                 .bound = f.bound,
                 .motion_change = (f.force - elastic_ - f.change).norm(),
                 .undamped_jump = f.undamped_jump};
}

// Tells the planner what is rendered here, so that it can be scored later.
ForceBar RenderLoop::bar(const ForceSwitch::Frame& frame) noexcept {
  if (const auto newer = link_.bars.take()) bar_ = *newer;
  const Model* const newest = models_.newest();
  const bool jets = newest && newest->has_jets();
  const JetEstimate own = jets ? newest->estimate(hip().at) : JetEstimate{};
  const double scale = jets ? own.error * bar_.scale.stretched() : bar_.scale.at(hip().at, frame.undamped);
  const double residual = (frame.force - frame.undamped).norm();
  link_.rendered.push({hip().at, frame.force, scale, residual, bar_.label});
  ForceBar made{.scale = scale, .trusted = own.trusted};
  for (std::size_t i = 0; i < made.half_width.size(); ++i)
    made.half_width[i] =
        std::max(std::hypot(bar_.factors[i] * scale, residual), bar_floor(frame.force, jnd_));
  return made;
}

void RenderLoop::send(double started) noexcept {
  const std::size_t left = end_.frames - std::min(end_.frames, next() - 1);  // this frame included
  const std::size_t needed = safety().frames_to_zero();
  end_.ending = end_.ending || left <= needed + needed / 4 + 1;
  input_.beat = link_.planner_beat.load(std::memory_order_relaxed);
  if (const Model* newest = models_.newest(); output_.wants_model(models_.came()) && newest) {
    ModelView view;
    newest->evaluate(hip().at, view.here, view.jacobian);
    view.half_way = newest->force(0.5 * hip().at);
    output_.note_model(hip().at, view, models_.came());
  }
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
