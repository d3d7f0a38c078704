#pragma once
// Meshes of phantoms, kept in the cache folder: making one takes a tenth of a second, a tenth of a short session. A file
// is of one revision of what makes meshes (sources, compiler, machine), and a damaged one is made anew.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

// phantom(name, elements), the same bits from the file or made.
TetMesh cached_phantom(std::string_view name, std::size_t elements);

// The whole mesh as bytes that end in their own SHA-256, and back; nothing where the bytes are not of one.
std::string mesh_bytes(const TetMesh& mesh);
std::optional<TetMesh> mesh_of_bytes(std::string_view bytes);

}  // namespace forefeel
