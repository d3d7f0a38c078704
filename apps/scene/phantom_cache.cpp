#include "apps/scene/phantom_cache.hpp"

#include <cstdint>
#include <fstream>
#include <sstream>

#include "apps/scene/cache_folder.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/packer.hpp"
#include "geometry/common/sha256.hpp"
#include "geometry/meshing/phantom.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view magic = "forefeel mesh 1\n";
constexpr std::size_t digest = 64;              // hexadecimal digits at the end
constexpr std::size_t most_elements = 100'000;  // larger meshes are not cached

fs::path file_of(std::string_view name, std::size_t elements) {
  const fs::path folder = cache_folder();
  if (folder.empty() || elements > most_elements) return {};
  Sha256 hash;
  hash.add(name)
      .add(static_cast<std::int64_t>(elements))
      .add(FOREFEEL_GEOMETRY_SOURCES)
      .add(solver_revision());
  return folder / (hash.hex().substr(0, 32) + ".mesh");
}

}  // namespace

std::string mesh_bytes(const TetMesh& mesh) {
  Packer out;
  out.add_raw(magic);
  out.add(mesh.nodes);
  out.add(mesh.tets);
  for (const auto& [name, nodes] : mesh.groups) {
    out.add(std::string_view(name));
    out.add(nodes);
  }
  const Bytes packed = out.take();
  std::string bytes(packed.begin(), packed.end());
  return bytes + Sha256().add(bytes).hex();
}

std::optional<TetMesh> mesh_of_bytes(std::string_view bytes) {
  if (bytes.size() < magic.size() + digest || !bytes.starts_with(magic)) return {};
  const std::string_view sum = bytes.substr(bytes.size() - digest);
  bytes.remove_suffix(digest);
  if (Sha256().add(bytes).hex() != sum) return {};
  bytes.remove_prefix(magic.size());
  TetMesh mesh;
  try {
    Unpacker in(Bytes(bytes.begin(), bytes.end()));
    mesh.nodes = in.values<Vec3>();
    mesh.tets = in.values<Tet>();
    while (in.left() > 0) {
      std::string name = in.text();
      mesh.groups.emplace(std::move(name), in.values<NodeIndex>());
    }
  } catch (const MalformedMessage&) {
    return {};
  }
  return mesh;
}

TetMesh cached_phantom(std::string_view name, std::size_t elements) {
  const fs::path file = file_of(name, elements);
  if (std::ifstream in(file, std::ios::binary); !file.empty() && in) {
    std::ostringstream bytes;
    bytes << in.rdbuf();
    if (std::optional<TetMesh> mesh = mesh_of_bytes(bytes.view())) return std::move(*mesh);
  }
  TetMesh mesh = phantom(name, elements);
  if (file.empty()) return mesh;
  try {
    write_whole(file, mesh_bytes(mesh));
  } catch (const std::exception&) {  // for example a full disk; the mesh is made again next time
  }
  return mesh;
}

}  // namespace forefeel
