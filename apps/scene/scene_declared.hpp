#pragma once
// Every key of a scene (scene_rows.hpp). SceneTable accepts only these keys, and `forefeel help scene` prints them.

#include <string>
#include <vector>

#include "apps/scene/scene_rows.hpp"

namespace forefeel {

// Each is declared beside its reader. scene_rows(): all of them, in the order of a file.
const SceneRowList& body_rows();         // [body]
const SceneRowList& material_rows();     // [material], [[material.viscosity]]
const SceneRowList& clamp_rows();        // [clamp]
const SceneRowList& contact_rows();      // [contact]
const SceneRowList& state_space_rows();  // [state_space]
const SceneRowList& model_rows();        // [model]
const SceneRowList& session_rows();      // [session], [session.jnd], [session.limits]
const SceneRowList& hand_rows();         // [hand]: profile, and the settings of hand:PROFILE
const std::vector<const SceneRowList*>& scene_rows();
// Their names: the keys of the scene itself.
std::vector<std::string> scene_sections();

bool is_scene_section(const std::string& name);

// For `forefeel help`: nested tables behind their parent, "session", "session.jnd" …
const std::vector<DeclaredTable>& scene_tables();

// True for two different keys that exclude each other, given with their section: "contact.node", "contact.group".
bool exclude_each_other(const std::string& key, const std::string& other);
// "has no effect where states arrive at given times (<arrivals>), …"
std::string no_effect_beside(const std::string& arrivals);

}  // namespace forefeel
