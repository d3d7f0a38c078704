#include "scheduling/touch/surface_contact.hpp"

namespace forefeel {

SurfaceContact::SurfaceContact(const TouchTask& task, LoopLink& link, const SwitchOptions& options)
    : link_(link),
      field_(task.field_of_sites()),
      friction_(task.friction),
      options_(options),
      switch_(options) {}

void SurfaceContact::take(const SurfaceModel* model) noexcept {
  model_ = model;
  field_.use(model->deep.get());
}

ForceSwitch::Step SurfaceContact::step(const HipSample& tip, TouchRecord& record) noexcept {
  const SurfaceModel* came = link_.surfaces.take().value_or(nullptr);
  const Vec3 before = touch_.tip;
  const TouchFrame frame = touch(field_, touch_, tip.at, friction_);  // with the model so far
  touch_ = frame.touch;
  came_ = came != nullptr;
  holds_ = touch_.kind != TouchKind::none;
  begins_ = !holds_ || frame.began;
  record = {.applies = true,
            .kind = touch_.kind,
            .inside = touch_.inside,
            .tip_change = frame.snaps ? 0 : frame.tip_change,  // in a snap the body moves by itself
            .energy = frame.energy,
            .lost = frame.lost};
  if (begins_) switch_ = ForceSwitch(options_);
  if (!holds_) {
    if (came) take(came);
    return {};
  }
  record.site = touch_.site, record.normal = frame.normal, record.at_border = frame.at_border;
  record.snaps = frame.snaps;
  const double push = frame.force.dot(frame.normal);
  if (push > 0) record.slope = frame.drive.norm() / push;
  Vec3 now = frame.force;
  if (came) {
    take(came);
    const SiteTerms terms = field_.at(touch_.site, tip.at - touch_.site.at, false).at;
    now = touch_.force = terms.force, record.energy = terms.energy;
  }
  return switch_.step(frame.force, now, came_, (tip.at - before).norm());
}

bool SurfaceContact::view(ModelView& view) noexcept {
  view = {};
  if (!holds_) return true;
  const Vec3 x = touch_.tip - touch_.site.at;
  const SiteTerms terms = field_.at(touch_.site, x).at;
  view.here = terms.force, view.jacobian = -terms.stiffness;
  view.half_way = field_.at(touch_.site, 0.5 * x, false).at.force;
  return true;
}

}  // namespace forefeel
