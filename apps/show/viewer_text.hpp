#pragma once
// The texts of the viewer: its script and style (apps/show/viewer), and the scripts of three.js that it uses.

#include <string_view>

namespace forefeel {

// The texts embedded by the build; those of three.js are empty if the build did not find it.
std::string_view embedded_viewer_script();
std::string_view embedded_viewer_style();
std::string_view embedded_three();           // three.min.js
std::string_view embedded_orbit_controls();  // OrbitControls.js

}  // namespace forefeel
