#pragma once
// A label volume as the mesher sees it. Private to this room.

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/segmentation/label_volume.hpp"

namespace forefeel {

// Subdomains of a volume: 0 outside, 1, 2, … for the wanted labels in ascending order.
class LabelDomain {
 public:
  LabelDomain(const LabelVolume& volume, std::vector<int> subdomain_of_value);

  int voxel(std::int64_t i, std::int64_t j, std::int64_t k) const;  // 0 beyond the volume
  // The subdomain with the largest trilinear weight at x [m]; of equal weights, the lowest subdomain.
  int at(const Vec3& x) const;
  Box box() const;                                // of all wanted voxels, one voxel wider on each side [m]
  double smallest_step() const;                   // least spacing [m]
  std::size_t wanted() const { return wanted_; }  // voxels
  double volume_of_body() const;                  // of all wanted voxels [m^3]

  // A voxel of each part of a subdomain; parts are connected over faces of voxels.
  struct Part {
    Vec3 at;  // [m]
    int subdomain = 0;
    std::size_t voxels = 0;
    bool touches_border = false;
  };
  const std::vector<Part>& parts() const { return parts_; }
  // The parts from which the mesher starts: parts of fewer than 8 voxels are left out if their label has a larger one.
  std::vector<Part> seeded() const;

  // Pairs of neighbouring voxel centres, the first in the body, that an interface separates [m]. Pairs on the same side
  // of the body are at least `apart` from one another [m]; every face of voxels has a pair within that distance.
  std::vector<std::array<Vec3, 2>> across_interfaces(double apart) const;

 private:
  Vec3 inward(const std::array<std::int64_t, 3>& voxel, const Vec3& otherwise) const;
  void find_parts();

  const LabelVolume& volume_;
  std::vector<int> subdomain_;  // of each position in values
  Mat3 to_index_;
  std::array<std::int64_t, 3> low_{}, high_{};  // of the wanted voxels
  std::size_t wanted_ = 0;
  std::vector<Part> parts_;
};

// Progress that the meshing process reports: LabelMeshStep, and the number of meshes made so far.
struct LabelTold {
  std::atomic<int> step = 0, meshes = 0;
};

// The tetrahedra of a domain and the subdomain of each. Not yet checked.
struct LabelledTets {
  std::vector<Vec3> nodes;
  std::vector<Tet> tets;
  std::vector<int> subdomain;  // #T, from 1
};
// Moves nodes of flat tetrahedra: inner ones freely, those of interfaces by a few hundredths of an edge. Does nothing
// where no dihedral angle is below 5 degrees.
void mend_slivers(LabelledTets& mesh);
bool has_flat_tets(const LabelledTets& mesh);  // that check_and_orient() refuses

// seconds: time limit of perturbation, and again of exudation [s].
LabelledTets mesh_domain(const LabelDomain& domain, std::size_t elements, double seconds, LabelTold& told);

}  // namespace forefeel
