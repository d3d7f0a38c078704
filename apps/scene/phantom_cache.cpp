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

constexpr std::string_view magic = "forefeel mesh 2\n";
constexpr std::size_t digest = 64;              // hexadecimal digits at the end
constexpr std::size_t most_elements = 100'000;  // larger meshes are not cached

fs::path file_of(const PhantomRequest& request) {
  const fs::path folder = cache_folder();
  if (folder.empty() || request.elements > most_elements) return {};
  Sha256 hash;
  hash.add(request.name)
      .add(static_cast<std::int64_t>(request.elements))
      .add(FOREFEEL_GEOMETRY_SOURCES)
      .add(solver_revision());
  if (request.toward) {
    for (const double value : request.toward->site) hash.add(value);
    hash.add(request.toward->radius);
  }
  if (request.rim) hash.add(static_cast<std::int64_t>(request.rim->axis)).add(request.rim->share);
  return folder / (hash.hex().substr(0, 32) + ".mesh");
}

TetMesh made(const PhantomRequest& request) {
  if (!request.toward) return phantom(request.name, request.elements);
  return graded_phantom(request.name,
                        {.elements = request.elements, .toward = *request.toward, .rim = request.rim});
}

}  // namespace

std::string mesh_bytes(const TetMesh& mesh) {
  Packer out;
  out.add_raw(magic);
  out.add(mesh.nodes);
  out.add(mesh.tets);
  const auto add_groups = [&](const auto& groups) {
    out.add(static_cast<std::uint32_t>(groups.size()));
    for (const auto& [name, members] : groups) {
      out.add(std::string_view(name));
      out.add(members);
    }
  };
  add_groups(mesh.groups);
  add_groups(mesh.element_groups);
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
    const auto read_groups = [&](auto& groups) {
      using Index = typename std::remove_reference_t<decltype(groups)>::mapped_type::value_type;
      for (auto left = in.number<std::uint32_t>(); left > 0; --left) {
        std::string name = in.text();
        groups.emplace(std::move(name), in.values<Index>());
      }
    };
    read_groups(mesh.groups);
    read_groups(mesh.element_groups);
    if (in.left() > 0) return {};
  } catch (const MalformedMessage&) {
    return {};
  }
  return mesh;
}

TetMesh cached_phantom(const PhantomRequest& request) {
  const fs::path file = file_of(request);
  if (std::ifstream in(file, std::ios::binary); !file.empty() && in) {
    std::ostringstream bytes;
    bytes << in.rdbuf();
    if (std::optional<TetMesh> mesh = mesh_of_bytes(bytes.view())) return std::move(*mesh);
  }
  TetMesh mesh = made(request);
  if (file.empty()) return mesh;
  try {
    write_whole(file, mesh_bytes(mesh));
  } catch (const std::exception&) {  // for example a full disk; the mesh is made again next time
  }
  return mesh;
}

}  // namespace forefeel
