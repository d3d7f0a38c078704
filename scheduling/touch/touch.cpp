#include "scheduling/touch/touch.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace forefeel {
namespace {

// The touch of a tip that has just come in; none through a clamped facet.
std::optional<SurfacePlace> begin(const SurfaceMap& map, const Touch& before, const Vec3& tip) {
  std::optional<SurfacePlace> place;
  if (before.known) place = crossing(map, before.tip, tip);
  if (!place) place = map.nearest(tip);
  if (map.facet(*place).clamped) return {};
  return place;
}

}  // namespace

std::optional<SurfacePlace> crossing(const SurfaceMap& map, const Vec3& outside, const Vec3& inside) {
  constexpr double rim = 1e-9;  // of barycentric coordinates, so that no way slips between two facets
  std::optional<SurfacePlace> first;
  double least = 1 + rim;
  for (std::size_t f = 0; f < map.facets().size(); ++f) {
    const Vec3& n = map.facets()[f].normal;
    const auto [a, b, c] = map.corners(static_cast<std::int32_t>(f));
    const double from = n.dot(outside - a), to = n.dot(inside - a);
    if (!(from >= 0 && to < 0)) continue;
    const double t = from / (from - to);
    if (t >= least) continue;
    const SurfacePlace place{static_cast<std::int32_t>(f), outside + t * (inside - outside)};
    if (map.barycentric(place).minCoeff() < -rim) continue;
    least = t, first = place;
  }
  return first;
}

TouchFrame touch(const TouchField& field, const Touch& before, const Vec3& tip,
                 std::optional<double> friction) {
  TouchFrame frame;
  Touch& now = frame.touch;
  now = before;
  now.tip = tip, now.known = true, now.inside = field.map().inside(tip);
  if (before.kind == TouchKind::none) {
    if (!now.inside || (before.known && before.inside)) return frame;
    frame.began = begin(field.map(), before, tip);
    if (!frame.began) return frame;
    now.site = *frame.began, now.kind = TouchKind::stick;
  }
  if (!now.inside) {
    const std::optional<SurfacePlace> way_out = crossing(field.map(), tip, before.tip);
    frame.left = way_out ? way_out->at : tip;
    frame.lost = field.at(now.site, *frame.left - now.site.at).at.energy;
    now.kind = TouchKind::none;
    return frame;
  }
  TouchTerms terms = field.at(now.site, tip - now.site.at);
  now.kind = TouchKind::stick;
  const bool pulled = terms.at.force.dot(terms.normal) < 0;
  if (pulled || friction) {
    const Slip slip = slide(field, now.site, tip, friction.value_or(0));
    frame.lost = slip.lost;
    if (slip.slid > 0) {
      now.kind = TouchKind::slip, now.site = slip.site;
      terms = field.at(now.site, tip - now.site.at);
    }
    if (pulled && slip.end != SlipEnd::sticks) {
      frame.lost += terms.at.energy;
      now.kind = TouchKind::none;
      return frame;
    }
  }
  frame.force = terms.at.force;
  frame.energy = terms.at.energy;
  return frame;
}

}  // namespace forefeel
