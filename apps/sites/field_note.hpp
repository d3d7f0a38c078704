#pragma once
// The field of a scene with contact.anywhere, in figures: what `info SCENE` and summaries say of it.

#include "apps/console/document_keys.hpp"
#include "apps/sites/palpation_map.hpp"
#include "apps/sites/scene_field.hpp"

namespace forefeel {

struct FieldNote {
  std::size_t sites = 0;
  double spacing = 0;                             // of the sites [m]
  double seconds = 0;                             // that making or reading it took
  bool kept = false;                              // read from the cache
  double area = 0;                                // of the free surface [m^2]
  std::optional<StiffnessRange> with_pad, alone;  // nullopt: no free node on the surface
};
// Solves the map of stiffness.
FieldNote field_note(const Scene& scene, const FieldFound& found, const Globals& globals);
const JsonKeys<FieldNote>& field_keys();
std::vector<std::string> in_words(const FieldNote& note);  // lines

}  // namespace forefeel
