#pragma once
// mesh --toward X,Y,Z,R: small elements at a contact.

#include <optional>
#include <string>

#include "apps/console/document_keys.hpp"
#include "geometry/meshing/surface.hpp"

namespace forefeel {

// "X,Y,Z,R": a place and a radius [m]. InputError at --toward.
Toward parse_toward(const std::string& text);

// A site on the surface, and what was made there.
struct MadeToward {
  Toward toward;             // the site on the surface
  double distance = 0;       // of the place that was given from it [m]
  double near = 0, far = 0;  // edges wanted at the site and far from it [m]
};
MadeToward on_surface(const Toward& given, const Surface& surface);
// Where the place is farther from the surface than the radius, a line that says so; else nothing.
std::optional<std::string> far_off(const MadeToward& made);
std::string in_words(const MadeToward& made);

const JsonKeys<MadeToward>& toward_keys();

}  // namespace forefeel
