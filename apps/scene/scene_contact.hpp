#pragma once
// The contact of a scene in figures: its surface, its springs, and which share of them pulls.

#include "apps/console/contact_json.hpp"
#include "apps/scene/scene.hpp"

namespace forefeel {

// Solves two states of a pad that has a place; of one anywhere, radius and stiffness alone are known.
ContactNote contact_note(const Scene& scene);

}  // namespace forefeel
