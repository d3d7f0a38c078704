#pragma once
// Meshes of phantoms (synthetic bodies), kept in the cache folder; making one takes a tenth of a second. A
// file is valid for one revision of the meshing sources, compiler and machine. A damaged file is replaced.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

// phantom(name, elements), from the cache if it is there; the same bits either way.
TetMesh cached_phantom(std::string_view name, std::size_t elements);

// The mesh as bytes that end in their own SHA-256, and back; nothing if the sum does not match.
std::string mesh_bytes(const TetMesh& mesh);
std::optional<TetMesh> mesh_of_bytes(std::string_view bytes);

}  // namespace forefeel
