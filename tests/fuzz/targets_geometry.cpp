// Meshes, surfaces and state files.

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/segmentation/label_volume.hpp"
#include "geometry/states/state_file.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/geometry/state_samples.hpp"
#include "tests/support/label_samples.hpp"
#include "tests/support/labelled_meshes.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/temporary_folder.hpp"

namespace forefeel::fuzz {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> mesh_extensions{".msh", ".vtk", ".vtu", ".mesh"},
    label_extensions{".nii", ".mha", ".nrrd", ".vti"},
    surface_extensions{".obj", ".off", ".stl", ".ply", ".vtk"};

void read_any_mesh(std::string_view input) {
  const NamedInput named = named_input(input, mesh_extensions);
  TetMesh mesh = read_mesh(file_of("mesh" + std::string(named.extension), named.content));
  check_and_orient(mesh, "mesh");
  surface_nodes(mesh);
  mesh_quality(mesh);
  for (const auto& [name, tets] : mesh.element_groups)
    for (const TetIndex tet : tets)
      if (tet >= mesh.tets.size()) throw std::logic_error("a group names a tetrahedron that is not there");
}

void read_any_surface(std::string_view input) {
  const NamedInput named = named_input(input, surface_extensions);
  const Surface surface = read_surface(file_of("surface" + std::string(named.extension), named.content));
  for (const Triangle& triangle : surface.triangles)
    for (const NodeIndex node : triangle)
      if (node >= surface.nodes.size()) throw std::logic_error("a triangle names a vertex that is not there");
}

void read_any_labels(std::string_view input) {
  const NamedInput named = named_input(input, label_extensions);
  const LabelVolume volume =
      read_label_volume(file_of("labels" + std::string(named.extension), named.content));
  if (volume.voxels.size() != static_cast<std::size_t>(volume.size[0] * volume.size[1] * volume.size[2]))
    throw std::logic_error("a volume without all of its voxels");
  for (const std::uint16_t voxel : volume.voxels)
    if (voxel >= volume.values.size()) throw std::logic_error("a voxel without a label");
}

void read_state_file(std::string_view input) {
  const fs::path file = file_of("s.states", input);
  for (const char* end : {"-wal", "-shm", "-journal"}) fs::remove(file.string() + end);
  for (const State& state : load_states(file).states)
    if (!state.at.allFinite()) throw std::logic_error("a state without a position");
}

std::vector<std::string> seeds_of(const std::map<std::string, std::string>& files) {
  std::vector<std::string> seeds;
  for (const auto& [name, content] : files) seeds.push_back(named_seed(fs::path(name).extension(), content));
  return seeds;
}

std::string bytes_of_states(int count) {
  const test::TemporaryFolder folder;
  const fs::path file = folder / "s.states";
  { StateFile::open_or_create(file, test::header()).append(test::states(count)); }
  std::ifstream in(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

}  // namespace

std::vector<Target> geometry_targets() {
  const auto mesh_seeds = [] {
    std::map<std::string, std::string> files = test::sample_mesh_files();
    files.merge(test::labelled_mesh_files());
    return seeds_of(files);
  };
  return {{"mesh", read_any_mesh, mesh_seeds},
          {"surface", read_any_surface, [] { return seeds_of(test::surface_files(test::unit_cube())); }},
          {"labels", read_any_labels,
           [] {
             return seeds_of(test::label_files(test::nested_spheres({5, 4, 3}, {1, 2, 3}, 4, 2)));
           }},
          {"states", read_state_file, [] {
             return std::vector{bytes_of_states(0), bytes_of_states(3), bytes_of_states(60)};
           }}};
}

}  // namespace forefeel::fuzz
