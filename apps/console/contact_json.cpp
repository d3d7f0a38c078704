#include "apps/console/contact_json.hpp"

#include "apps/console/json.hpp"

namespace forefeel {

const JsonKeys<ContactNote>& contact_keys() {
  using C = ContactNote;
  static const JsonKeys<C> keys{
      {"kind", "", "pad or rigid", [](const C& c) { return c.pad ? "pad" : "rigid"; }},
      {"radius", "m", "of the pad; null: rigid", &C::radius},
      {"pad", "N/m", "stiffness of the pad as the scene gives it; null: rigid", &C::stiffness},
      {"area", "m^2",
       "of the surface that the contact touches at rest; null, as what follows: the pad has no place",
       &C::area},
      {"stiffness", "N/m", "of the pad's springs over the surface; null: rigid", &C::springs},
      {"pulling_share", "1",
       "[inward, oblique]: share of the pad's force that pulls, pressed in by 10 mm and at 45 degrees to it; "
       "null: rigid",
       [](const C& c) {
         return c.pad ? json_numbers({c.pulling_share[0], c.pulling_share[1]}) : Json();
       }},
      {"clamped_share", "1", "of the pad's springs that stand on clamped nodes; null: rigid",
       &C::clamped_share},
      {"nodes", "", "of a rigid contact", &C::nodes},
      {"place", "m",
       "list of three: where the tip is at rest; null, as the next: a pad that touches anywhere",
       [](const C& c) { return c.place ? vector3((*c.place)[0]) : Json(); }},
      {"normal", "1", "list of three: mean outward normal of the body there",
       [](const C& c) { return c.place ? vector3((*c.place)[1]) : Json(); }}};
  return keys;
}

}  // namespace forefeel
