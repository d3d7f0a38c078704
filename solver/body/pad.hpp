#pragma once
// A compliant pad: springs between the rest surface and the tip of the device, about a fingertip. They act over the
// component S of {y on the surface : |y - s| < r} that holds the site s, or the surface nearest to it:
//   a(y) = 3 k_p / (pi r^2) (1 - |y - s|^2 / r^2)^2 g(n . m)    [N/m^3]
//   g(t) = 3 tau^2 - 2 tau^3, tau = 2 t clamped to [0, 1]
//   m    = mean of n over S, weighted by (1 - |y - s|^2 / r^2)^2, normalised
//   E(u; x) = W_body(u) + 1/2 int_S a(y) |u(y) - x|^2 dA     [J]
// k_p [N/m] stiffness, r [m] radius, n outward normal at y, u(y) [m] displacement, x [m] of the tip. g is 1 within 60
// degrees of m and 0 where the surface turns away. On a flat surface int_S a dA = k_p; elsewhere it is less or more,
// and not normalised. The springs pull as well as push: the tip is bonded, as a rigid patch is.

#include <array>
#include <span>
#include <vector>

#include "solver/body/body.hpp"

namespace forefeel {

// The springs of one triangle of the surface: int a N_i N_j dA [N/m] of its corners 0, 1, 2 and, for quadratic
// elements, the middles of its edges 01, 12, 20.
struct PadFacet {
  Triangle corners;
  int nodes = 3;  // 3 or 6
  std::array<std::array<double, 6>, 6> springs{};
};

struct PadSurface {
  std::vector<PadFacet> facets;
  Vec3 normal = Vec3::Zero();  // m; zero where the mean of n vanishes
  double area = 0;             // of S [m^2]
  double stiffness = 0;        // int_S a dA [N/m]
  bool other_part = false;     // the ball |y - s| < r holds surface that is not in S
};

// nodes_per_facet: 3 for linear elements, 6 for quadratic ones. Gauss quadrature over facet and ball, exact to 1e-10
// of k_p. Throws nothing: a site farther than r from the surface has no facets.
PadSurface pad_surface(const TetMesh& mesh, const Pad& pad, int nodes_per_facet = 3);

// a(y) [N/m^3] at a point of a facet of S with this normal (outward, of length 1), and its peak 3 k_p / (pi r^2).
double pad_density(const Pad& pad, const PadSurface& surface, const Vec3& y, const Vec3& normal);
double pad_peak(const Pad& pad);

// The point of the surface that is nearest to `point`.
Vec3 nearest_site(const TetMesh& mesh, const Vec3& point);

// Which share of a pad's springs pulls. A fingertip only pushes; the springs of a pad also pull, as if
// bonded:
//   q(y) = a(y) (x - u(y)) . x / |x|     [Pa]
//   pulling share = int max(0, -q) dA / int |q| dA
// a [N/m^3] density of the springs, x [m] position of the tip, u(y) [m] displacement of the surface.

// displacements: of the mesh's nodes, #V x 3 [m]. Midpoint rule over 256 parts of each facet, u linear over a facet.
// 0 without a pad and at rest.
double pulling_share(const Body& body, std::span<const double> displacements, const Vec3& x);

}  // namespace forefeel
