#pragma once
// The springs of a pad (solver/body/pad.hpp) at any place of the surface, and how they change as the site moves:
//   M_ij = int a N_i N_j dA,   m_i = int a N_i dA,   t = int a dA      [N/m]
//   da/ds = 3 k_p / (pi r^2) (4 F (y - s) / r^2 g + F^2 g'(n . m) dm/ds^T n),   F = 1 - |y - s|^2 / r^2
// with a(y), s, r, k_p, g and the mean normal m of pad.hpp. F and its slope vanish at the rim, so the integrals over
// the ball have continuous derivatives in s; the same quadrature gives both. i and j are free nodes of the surface.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "solver/jet/surface_map.hpp"

namespace forefeel {

// Numbers of the free nodes under each facet: corners, and the middles of its edges 01, 12, 20; -1 for a clamped one.
struct FacetNodes {
  int per_facet = 3;  // 3 or 6
  std::vector<std::array<std::int32_t, 6>> of;
};

struct PadAt {
  std::vector<std::int32_t> nodes;  // ascending
  Eigen::MatrixXd springs;          // M
  Eigen::VectorXd pull;             // m
  double total = 0;                 // t
  Vec3 normal = Vec3::Zero();       // zero where the mean normal vanishes
  double clamped_share = 0;         // of the springs, carried by clamped nodes
  // By the three coordinates of s [1/m of the above]; empty unless asked for.
  std::array<Eigen::MatrixXd, 3> springs_by;
  std::array<Eigen::VectorXd, 3> pull_by;
  Vec3 total_by = Vec3::Zero();
  Mat3 normal_by = Mat3::Zero();  // column k: by s_k
};

class MovingPad {
 public:
  // radius [m], stiffness [N/m]; the map must outlive this.
  MovingPad(const SurfaceMap& map, double radius, double stiffness, FacetNodes nodes);
  PadAt at(const SurfacePlace& site, bool slopes) const;
  Vec3 normal(const SurfacePlace& site) const;  // the mean normal alone
  double radius() const { return radius_; }

 private:
  struct Part;
  std::vector<std::int32_t> component(const SurfacePlace& site) const;
  Part integrate(std::int32_t facet, const Vec3& site, bool slopes) const;
  void gather(const std::vector<Part>& parts, bool slopes, PadAt& pad) const;

  const SurfaceMap& map_;
  double radius_, stiffness_;
  FacetNodes nodes_;
};

}  // namespace forefeel
