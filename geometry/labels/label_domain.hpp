#pragma once
// What the mesher of label volumes asks of a volume. Private to this room.

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "geometry/image/label_volume.hpp"
#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

// Subdomains of a volume: 0 outside, 1, 2, … for the wanted labels in ascending order.
class LabelDomain {
 public:
  LabelDomain(const LabelVolume& volume, std::vector<int> subdomain_of_value);

  int voxel(std::int64_t i, std::int64_t j, std::int64_t k) const;  // 0 beyond the volume
  // The subdomain with the greatest trilinear weight at x [m]; of equal ones the lowest.
  int at(const Vec3& x) const;
  Box box() const;                                // around all wanted voxels, and a voxel more [m]
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
  std::vector<Part> seeded() const;  // without specks of a few voxels where a label has more

 private:
  void find_parts();

  const LabelVolume& volume_;
  std::vector<int> subdomain_;  // of each position in values
  Mat3 to_index_;
  std::array<std::int64_t, 3> low_{}, high_{};  // of the wanted voxels
  std::size_t wanted_ = 0;
  std::vector<Part> parts_;
};

struct LabelTold {
  std::atomic<int> step = 0, meshes = 0;
};

// The tetrahedra of a domain and the subdomain of each. Not yet checked.
struct LabelledTets {
  std::vector<Vec3> nodes;
  std::vector<Tet> tets;
  std::vector<int> subdomain;  // #T, from 1
};
// seconds: what perturbation and exudation may take, each.
LabelledTets mesh_domain(const LabelDomain& domain, std::size_t elements, double seconds, LabelTold& told);

}  // namespace forefeel
