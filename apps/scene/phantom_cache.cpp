#include "apps/scene/phantom_cache.hpp"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>

#include "apps/scene/cache_folder.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/sha256.hpp"
#include "geometry/meshing/phantom.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view magic = "forefeel mesh 1\n";
constexpr std::size_t digest = 64;              // hexadecimal digits at the end
constexpr std::size_t most_elements = 100'000;  // larger meshes are not cached

template <class T>
void put(std::string& bytes, const T* values, std::size_t count) {
  const auto n = static_cast<std::uint64_t>(count);
  bytes.append(reinterpret_cast<const char*>(&n), sizeof n);
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

template <class T>
bool take(std::string_view& bytes, std::vector<T>& values) {
  std::uint64_t n = 0;
  if (bytes.size() < sizeof n) return false;
  std::memcpy(&n, bytes.data(), sizeof n);
  bytes.remove_prefix(sizeof n);
  if (n > bytes.size() / sizeof(T)) return false;
  values.resize(n);
  if (n > 0) std::memcpy(static_cast<void*>(values.data()), bytes.data(), n * sizeof(T));
  bytes.remove_prefix(n * sizeof(T));
  return true;
}

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
  std::string bytes(magic);
  put(bytes, mesh.nodes.data(), mesh.nodes.size());
  put(bytes, mesh.tets.data(), mesh.tets.size());
  for (const auto& [name, nodes] : mesh.groups) {
    put(bytes, name.data(), name.size());
    put(bytes, nodes.data(), nodes.size());
  }
  return bytes + Sha256().add(bytes).hex();
}

std::optional<TetMesh> mesh_of_bytes(std::string_view bytes) {
  if (bytes.size() < magic.size() + digest || !bytes.starts_with(magic)) return {};
  const std::string_view sum = bytes.substr(bytes.size() - digest);
  bytes.remove_suffix(digest);
  if (Sha256().add(bytes).hex() != sum) return {};
  bytes.remove_prefix(magic.size());
  TetMesh mesh;
  if (!take(bytes, mesh.nodes) || !take(bytes, mesh.tets)) return {};
  while (!bytes.empty()) {
    std::vector<char> name;
    std::vector<NodeIndex> nodes;
    if (!take(bytes, name) || !take(bytes, nodes)) return {};
    mesh.groups.emplace(std::string(name.begin(), name.end()), std::move(nodes));
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
    OutputFile out(file);
    out.write(mesh_bytes(mesh));
    out.commit();
  } catch (const std::exception&) {  // for example a full disk; the mesh is made again next time
  }
  return mesh;
}

}  // namespace forefeel
