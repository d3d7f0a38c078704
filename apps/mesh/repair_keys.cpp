#include "apps/mesh/repair_keys.hpp"

#include <nlohmann/json.hpp>

namespace forefeel {

const JsonKeys<RepairReport>& repair_keys() {
  using R = RepairReport;
  static const JsonKeys<R> keys{
      {"self_intersections", "", "pairs of triangles that intersected", &R::self_intersections},
      {"holes", "", "holes that were closed", &R::holes},
      {"components", "", "connected parts of the input", &R::components},
      {"crossing", "", "parts that crossed another one", &R::crossing},
      {"united", "", "true: the body is the union of these", &R::united},
      {"reoriented", "", "true: triangles were turned", &R::reoriented},
      {"wrapped", "", "true: the surface was wrapped anew, since it could not be repaired", &R::wrapped},
      {"triangles_before", "", "of the input", &R::triangles_before},
      {"triangles_after", "", "of the repaired surface", &R::triangles_after}};
  return keys;
}

}  // namespace forefeel
