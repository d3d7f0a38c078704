#include "apps/scene/scene_anywhere.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scene/scene_nodes.hpp"
#include "solver/body/pad.hpp"
#include "solver/sites/surface_map.hpp"

namespace forefeel {
namespace {

constexpr const char* without_place = ", anywhere";

}  // namespace

bool is_anywhere(const Scene& scene) {
  return scene.touch.anywhere.has_value();
}

std::optional<AnywhereKeys> read_anywhere(const SceneTable& contact, const SceneTable& state_space) {
  if (!is_anywhere(contact)) {
    for (const char* key : {"friction", "site_spacing"})
      if (contact.has(key))
        throw InputError(contact.where(key), "is for a pad that moves, expected contact.anywhere = true");
    if (state_space.has("depth"))
      throw InputError(state_space.where("depth"), "is for contact.anywhere = true, expected box");
    return {};
  }
  if (state_space.has("box"))
    throw InputError(state_space.where("box"), "is of one place, expected depth with contact.anywhere");
  AnywhereKeys keys;
  keys.depth = state_space.number("depth", positive()).value_or(usual_depth);
  keys.friction = contact.number("friction", not_negative());
  keys.site_spacing = contact.number("site_spacing", positive());
  return keys;
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

}  // namespace forefeel
