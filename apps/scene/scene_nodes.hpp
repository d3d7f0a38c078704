#pragma once
// The nodes that [clamp] and [contact] of a scene choose, and the pad of [contact].

#include <optional>
#include <vector>

#include "apps/scene/scene_table.hpp"
#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/meshing/surface.hpp"
#include "solver/body/pad.hpp"

namespace forefeel {

// is_phantom: where the table is empty, the group of its name.
std::vector<NodeIndex> read_clamp(const SceneTable& clamp, const TetMesh& mesh, bool is_phantom);
std::vector<NodeIndex> read_contact(const SceneTable& contact, const TetMesh& mesh, bool is_phantom);

// The clamp, where it is a low end of the body: its rim becomes edges of a graded mesh.
std::optional<LowEnd> rim_of(const SceneTable& clamp);

// contact.anywhere: the pad has no place of its own.
bool is_anywhere(const SceneTable& contact);

// The pad of [contact]; nullopt without the key `pad`; with contact.anywhere its site is not set. tip: of a phantom.
std::optional<Pad> read_pad(const SceneTable& contact, const TetMesh& mesh, const std::optional<Vec3>& tip);

}  // namespace forefeel
