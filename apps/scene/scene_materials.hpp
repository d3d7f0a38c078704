#pragma once
// The materials of a scene: [material], or [[material]] tables of which all but one name a group of tetrahedra.

#include <string>
#include <vector>

#include "approx/switch/relaxation.hpp"
#include "apps/scene/scene_table.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

struct MaterialTable {
  SceneTable table;
  std::string group;  // empty: the rest of the body
  Material material;
};

// defaults: keys that are not given have default values, as for phantoms.
std::vector<MaterialTable> read_materials(const std::vector<SceneTable>& tables, bool defaults);

// The viscosity of the body. All tables must have the same one, because the rendered force has a single relaxation
// function; InputError otherwise.
Viscosity read_viscosity(const std::vector<SceneTable>& tables);

// Sets the body's material and regions. InputError: a group that the mesh does not name, tetrahedra in two
// groups or in none. Warns of a table without effect.
void assign_materials(const std::vector<MaterialTable>& tables, Body& body,
                      std::vector<std::string>& warnings);

}  // namespace forefeel
