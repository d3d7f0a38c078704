#include "apps/mesh/mesh_toward.hpp"

#include <fmt/format.h>

#include "apps/console/json.hpp"
#include "apps/console/values.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {

Toward parse_toward(const std::string& text) {
  const std::size_t last = text.rfind(',');
  if (last == std::string::npos)
    throw InputError("--toward", fmt::format("'{:.80}', expected a place and a radius X,Y,Z,R in m", text));
  const std::string radius = text.substr(last + 1);
  if (const std::string problem = above_zero(radius); !problem.empty())
    throw InputError("--toward", "radius R " + problem);
  return {parse_vector(text.substr(0, last), "--toward"), std::strtod(radius.c_str(), nullptr)};
}

MadeToward on_surface(const Toward& given, const Surface& surface) {
  const Vec3 site = nearest_point(surface, given.site);
  return {.toward = {site, given.radius}, .distance = (site - given.site).norm()};
}

std::optional<std::string> far_off(const MadeToward& made) {
  if (made.distance <= made.toward.radius) return std::nullopt;
  const Vec3& site = made.toward.site;
  return fmt::format("the place is {:.3g} m from the surface, taken to {:.4g}, {:.4g}, {:.4g}", made.distance,
                     site.x(), site.y(), site.z());
}

std::string in_words(const MadeToward& made) {
  return fmt::format("edges of about {:.2g} mm at the site, {:.2g} mm far from it", 1e3 * made.near,
                     1e3 * made.far);
}

const JsonKeys<MadeToward>& toward_keys() {
  using M = MadeToward;
  static const JsonKeys<M> keys{
      {"site", "m", "the place, on the surface", [](const M& m) { return vector3(m.toward.site); }},
      {"radius", "m", "within which elements are smallest", [](const M& m) { return m.toward.radius; }},
      {"distance", "m", "of the place that was given from the surface", &M::distance},
      {"near", "m", "edge wanted at the site", &M::near},
      {"far", "m", "edge wanted far from it", &M::far}};
  return keys;
}

}  // namespace forefeel
