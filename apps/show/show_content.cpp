#include "apps/show/show_content.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace forefeel {

Box extent_of(const ShowContent& content) {
  bool any = false;
  Box all;
  const auto add = [&](const Vec3& p) {
    all = any ? Box{all.low.cwiseMin(p), all.high.cwiseMax(p)} : Box{p, p};
    any = true;
  };
  if (content.body)
    for (const Vec3& p : content.body->nodes) add(p);
  if (content.box) add(content.box->low), add(content.box->high);
  if (content.states)
    for (const ShownState& s : content.states->all) add(s.state.at);
  if (content.run)
    for (const ShownFrame& f : content.run->path) add(f.at);
  return all;
}

ViewPoint view_of(const ShowContent& content) {
  ViewPoint view;
  if (!content.body || !content.body->outward) return view;
  const Vec3& outward = *content.body->outward;
  constexpr double degrees = 180 / std::numbers::pi;
  if (std::hypot(outward.x(), outward.y()) > 0.3)
    view.azimuth = std::round(std::atan2(outward.y(), outward.x()) * degrees) + 35;
  view.elevation =
      std::clamp(std::round(std::asin(std::clamp(outward.z(), -1.0, 1.0)) * degrees), -35.0, 35.0);
  if (std::abs(view.elevation) < 15) view.elevation = 20;
  return view;
}

}  // namespace forefeel
