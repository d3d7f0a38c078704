#pragma once
// Meshes of phantoms (synthetic bodies), kept in the cache folder because making one takes 0.1 s. A file is
// valid for one revision of the meshing sources, one compiler and one machine. A damaged file is replaced.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct PhantomRequest {
  std::string name;
  std::size_t elements = 0;           // 0: the default of the phantom
  std::optional<Toward> toward = {};  // graded toward a contact
  std::optional<LowEnd> rim = {};     // with toward: of another clamp than the group's
};
// phantom() or graded_phantom(), from the cache if possible. The result has the same bits either way.
TetMesh cached_phantom(const PhantomRequest& request);

// The mesh as bytes with their SHA-256 at the end, and back. Returns nothing if the sum does not match.
std::string mesh_bytes(const TetMesh& mesh);
std::optional<TetMesh> mesh_of_bytes(std::string_view bytes);

}  // namespace forefeel
