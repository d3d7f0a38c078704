#include "scheduling/touch/touch.hpp"

#include <algorithm>

namespace forefeel {
namespace {

// The touch of a tip that has just come in; none through a clamped facet.
std::optional<SurfacePlace> begin(const TouchField& field, const Touch& before, const Vec3& tip) {
  std::optional<SurfacePlace> place;
  if (before.known) place = field.grid().crossing(before.tip, tip);
  if (!place) place = field.map().nearest(tip);
  if (field.map().facet(*place).clamped) return {};
  return place;
}

}  // namespace

TouchFrame touch(const TouchField& field, const Touch& before, const Vec3& tip,
                 std::optional<double> friction) {
  TouchFrame frame;
  Touch& now = frame.touch;
  now = before;
  now.tip = tip, now.known = true, now.inside = field.grid().inside(tip);
  if (before.kind == TouchKind::none) {
    if (!now.inside || (before.known && before.inside)) return frame;
    frame.began = begin(field, before, tip);
    if (!frame.began) return frame;
    now.site = *frame.began, now.kind = TouchKind::stick;
  }
  if (!now.inside) {
    const std::optional<SurfacePlace> way_out = field.grid().crossing(tip, before.tip);
    frame.left = way_out ? way_out->at : tip;
    frame.lost = std::max(0.0, field.at(now.site, *frame.left - now.site.at, false).at.energy);
    now.kind = TouchKind::none;
    return frame;
  }
  now.kind = TouchKind::stick;
  TouchTerms terms;
  if (!friction) terms = field.at(now.site, tip - now.site.at, false);
  if (friction || terms.at.force.dot(terms.normal) < 0) {
    const Slip slip = slide(field, now.site, tip, friction.value_or(0), now.steepness);
    terms = slip.terms;
    now.steepness = slip.steepness;
    frame.lost = slip.lost;
    frame.at_border = slip.end == SlipEnd::border;
    if (slip.slid > 0) now.kind = TouchKind::slip, now.site = slip.site;
    if (slip.pulled && slip.end != SlipEnd::sticks) {
      frame.lost += std::max(0.0, terms.at.energy);
      now.kind = TouchKind::none;
      return frame;
    }
  }
  frame.force = terms.at.force;
  frame.energy = terms.at.energy;
  frame.normal = terms.normal;
  frame.drive = drive(field, now.site, terms);
  return frame;
}

}  // namespace forefeel
