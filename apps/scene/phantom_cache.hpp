#pragma once
// Meshes of phantoms (synthetic bodies), kept in the cache folder because making one takes 0.1 s. A file is
// valid for one revision of the meshing sources, one compiler and one machine. A damaged file is replaced.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

// phantom(name, elements), from the cache if possible. The result has the same bits either way.
TetMesh cached_phantom(std::string_view name, std::size_t elements);

// The mesh as bytes with their SHA-256 at the end, and back. Returns nothing if the sum does not match.
std::string mesh_bytes(const TetMesh& mesh);
std::optional<TetMesh> mesh_of_bytes(std::string_view bytes);

}  // namespace forefeel
