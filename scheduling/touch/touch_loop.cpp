#include "scheduling/touch/touch_loop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace forefeel {

std::string_view name(TouchKind kind) {
  return kind == TouchKind::none ? "none" : kind == TouchKind::stick ? "stick" : "slip";
}

namespace {

std::size_t spare_of(const RenderOptions& render) {
  const double needed = render.safety.force_limit / (render.safety.slew_limit * render.frame);
  return static_cast<std::size_t>(std::min(std::ceil(1.25 * needed), 1e3));
}

}  // namespace

TouchLoop::TouchLoop(Device& device, FieldOfSites& field, TouchLink& link, const TouchLoopOptions& options,
                     std::size_t frames, std::function<double()> now)
    : field_(field),
      link_(link),
      options_(options),
      tip_(device, options.render.frame, options.render.switching.jump_speed),
      frames_(frames),
      switch_(options.render.switching),
      fresh_filter_(options.render.viscosity.empty()
                        ? std::optional<RelaxationFilter>()
                        : std::optional<RelaxationFilter>(options.render.viscosity)),
      filter_(fresh_filter_),
      output_(options.render, std::move(now)),
      ramp_(std::min(spare_of(options.render), frames)),
      log_(frames + 2 * spare_of(options.render)) {
  if (output_.controlled()) uncontrolled_.resize(log_.size());
}

Vec3 TouchLoop::rendered(const TouchFrame& frame, const TouchModel* came, double dt,
                         TouchFrameRecord& record) {
  const bool touching = frame.touch.kind != TouchKind::none;
  if (!touching || frame.began) {
    switch_ = ForceSwitch(options_.render.switching);
    filter_ = fresh_filter_;
    last_elastic_.setZero();
  }
  if (!touching) {
    if (came) model_ = came, field_.use(came->deep.get());
    return Vec3::Zero();
  }
  const Vec3 x = frame.touch.tip - frame.touch.site.at;
  Vec3 now = frame.force;
  if (came) {  // the touch was found with the model so far
    model_ = came;
    field_.use(came->deep.get());
    now = field_.at(frame.touch.site, x, false).at.force;
  }
  const ForceSwitch::Frame step =
      switch_.step(frame.force, now, came != nullptr, (frame.touch.tip - last_tip_).norm());
  record.step.took_model = step.took_model;
  record.step.delta = step.change, record.step.change = step.change.norm(), record.step.bound = step.bound;
  record.step.undamped_jump = step.undamped_jump;
  record.step.motion_change = (step.force - last_elastic_ - step.change).norm();
  last_elastic_ = step.force;
  record.force.undamped = step.undamped, record.force.elastic = step.force;
  return filter_ ? filter_->step(step.force, dt) : step.force;
}

void TouchLoop::note_source(const TouchFrame& frame, TouchFrameRecord& record) {
  if (model_ != nullptr) record.source.model = model_->serial, record.source.known = model_->known;
  if (frame.touch.kind == TouchKind::none) return;
  record.normal = frame.normal, record.source.at_border = frame.at_border;
  const double push = frame.force.dot(frame.normal);
  record.source.slope = push > 0 ? frame.drive.norm() / push : unknown;
}

void TouchLoop::send(const TouchFrame& frame, bool came, double started, TouchFrameRecord& record) {
  const bool touching = frame.touch.kind != TouchKind::none;
  const Vec3 rest = touching ? frame.touch.site.at : frame.touch.tip, x = frame.touch.tip - rest;
  output_.rest_at(rest);
  if (output_.wants_model(came)) {
    ModelView view;
    if (touching) {
      const SiteTerms terms = field_.at(frame.touch.site, x).at;
      view.here = terms.force, view.jacobian = -terms.stiffness;
      view.half_way = field_.at(frame.touch.site, 0.5 * x, false).at.force;
    }
    output_.note_model(frame.touch.tip, view, came);
  }
  record.force.sent = output_.send(record.force.rendered, tip_.tip(),
                                   {.started = started,
                                    .beat = link_.planner_beat.load(std::memory_order_relaxed),
                                    .ending = ending_ || frame_ + ramp_ >= frames_});
}

void TouchLoop::frame(std::size_t k, double started) {
  frame_ = k;
  const HipSample& tip = tip_.read(k, output_.sent());
  const TouchModel* came = link_.models.take().value_or(nullptr);
  TouchFrameRecord record;
  record.t = tip.t, record.tip = tip.at;
  const TouchFrame frame = touch(field_, touch_, tip.at, options_.friction);
  touch_ = frame.touch;
  record.touch = touch_.kind, record.site = touch_.site;
  unfelt_ += touch_.kind == TouchKind::none && touch_.inside;
  record.energy = frame.energy, record.lost = frame.lost;
  const double dt = done_ > 0 ? tip.t - last_t_ : options_.render.frame;
  record.force.rendered = rendered(frame, came, dt, record);
  note_source(frame, record);
  send(frame, came != nullptr, started, record);
  link_.seen.publish({.tip = tip, .touching = touch_.kind != TouchKind::none, .site = touch_.site});
  last_tip_ = tip.at, last_t_ = tip.t;
  if (done_ >= log_.size()) return;
  if (output_.controlled()) uncontrolled_[done_] = output_.uncontrolled();
  log_[done_++] = record;
}

void TouchLoop::note_timing(double cost_us, double lateness_us) noexcept {
  if (done_ > 0) log_[done_ - 1].timing = {cost_us, lateness_us};
}

std::vector<TouchFrameRecord> TouchLoop::take_log() {
  log_.resize(done_);
  return std::move(log_);
}

std::vector<Vec3> TouchLoop::take_uncontrolled() {
  if (output_.controlled()) uncontrolled_.resize(done_);
  return std::move(uncontrolled_);
}

}  // namespace forefeel
