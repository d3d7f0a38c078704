#pragma once
// The parts of a scene that make a body: mesh, material, clamp, contact.

#include <filesystem>

#include "apps/scene_input/scene_table.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

struct BodySections {
  SceneTable body, material, clamp, contact;
};

// Reads, tetrahedralises or makes the mesh and fills the node sets; warnings of mesh and material are
// appended.
Body read_body(const BodySections& sections, const std::filesystem::path& folder, const std::string& file,
               std::vector<std::string>& warnings);

// Opposite to the area-weighted mean outward normal of the contact (the grasped patch): the direction of
// pressing.
Vec3 inward_direction(const Body& body);

// Where states are placed when a scene gives no box: per axis a sixth of the body's longest side, at most 0.4
// of its own side, in whole spacings.
Box default_box(const TetMesh& mesh, double spacing);

}  // namespace forefeel
