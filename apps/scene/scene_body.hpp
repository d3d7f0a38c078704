#pragma once
// The parts of a scene that make a body: mesh, material, clamp, contact.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/scene/scene_accuracy.hpp"
#include "apps/scene/scene_table.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

struct BodySections {
  SceneTable body;
  std::vector<SceneTable> materials;
  SceneTable clamp, contact;
  std::string text = {};  // of all of them
};

struct FineBodies;  // scene_fine.hpp

struct BodyRead {
  Body body;
  std::shared_ptr<const FineBodies> fine =
      {};                                  // with contact.anywhere: they have no jets before a site is known
  std::optional<AccuracyChoice> accuracy;  // with body.accuracy
};

// Makes the mesh (reads a file, fills a surface or builds a phantom) and the node sets. Appends warnings
// about mesh and material. quiet: no progress line where a fine body is solved.
BodyRead read_body(const BodySections& sections, const std::filesystem::path& folder, const std::string& file,
                   bool quiet, std::vector<std::string>& warnings);

// Direction of pressing: opposite to the area-weighted mean outward normal of the contact (the grasped
// patch).
Vec3 inward_direction(const Body& body);

// Default box for states if the scene gives none. Its reach along each axis is a sixth of the body's longest
// side, at most 0.4 of the side along that axis, in whole spacings.
Box default_box(const TetMesh& mesh, double spacing);

}  // namespace forefeel
