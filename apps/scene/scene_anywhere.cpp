#include "apps/scene/scene_anywhere.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "solver/body/pad.hpp"
#include "solver/sites/surface_map.hpp"

namespace forefeel {
namespace {

constexpr const char* without_place = ", anywhere";

}  // namespace

bool is_anywhere(const Scene& scene) {
  const auto contact = scene.identity.find("contact");
  return contact != scene.identity.end() && contact->second.ends_with(without_place);
}

std::string anywhere_in_words(const Pad& pad) {
  return fmt::format("pad of {} N/m, radius {} m{}", pad.stiffness, pad.radius, without_place);
}

Vec3 free_site(const Body& body, const InputPlace& where) {
  const SurfaceMap map(body);
  const auto free_area = [](const SurfaceMap::Facet& facet) { return facet.clamped ? 0.0 : facet.area; };
  const auto widest = std::ranges::max_element(map.facets(), {}, free_area);
  if (widest == map.facets().end() || !(free_area(*widest) > 0))
    throw InputError(where, "all of the surface is clamped, expected a part that can move");
  const auto [a, b, c] = map.corners(static_cast<std::int32_t>(widest - map.facets().begin()));
  return (a + b + c) / 3;
}

SitedBody put_at(const Scene& scene, const Vec3& wanted) {
  const SurfaceMap map(*scene.body);
  const SurfacePlace site = map.nearest(wanted);
  const auto in_words = [](const Vec3& x) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", x[0], x[1], x[2]);
  };
  const double distance = (site.at - wanted).norm();
  if (!(distance <= longest_side(scene.body->mesh)))
    throw InputError("--site",
                     fmt::format("{} is {:.3g} m from the surface, farther than the body is long; expected "
                                 "a place near it, in metres",
                                 in_words(wanted), distance));
  if (map.facet(site).clamped)
    throw InputError("--site",
                     fmt::format("{} is on a clamped facet (nearest to {}), expected a place that can move",
                                 in_words(site.at), in_words(wanted)));
  auto body = std::make_shared<Body>(*scene.body);
  body->pad->site = site.at;
  SitedBody sited{.body = body,
                  .clamped_share = clamped_share(*body, pad_surface(body->mesh, *body->pad)),
                  .warnings = check(*body, scene.source.file.string())};
  if (sited.clamped_share > 0)
    sited.warnings.push_back(
        fmt::format("the pad at {} reaches over the clamp: {:.1f} % of its springs pull on clamped "
                    "nodes",
                    in_words(site.at), 100 * sited.clamped_share));
  return sited;
}

}  // namespace forefeel
