#include "solver/body/pad_pull.hpp"
#include "solver/body/pad.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace forefeel {
namespace {

constexpr int parts = 16;  // of each edge

// Visits the centroids of the parts^2 equal triangles of a facet, in barycentric coordinates.
template <class Visit>
void over_parts(const Visit& visit) {
  for (int i = 0; i < parts; ++i)
    for (int j = 0; i + j < parts; ++j)
      for (const double shift : {1.0 / 3, 2.0 / 3}) {
        if (shift > 0.5 && i + j + 1 >= parts) continue;
        const double a = (i + shift) / parts, b = (j + shift) / parts;
        visit(Vec3(1 - a - b, a, b));
      }
}

}  // namespace

double pulling_share(const Body& body, std::span<const double> displacements, const Vec3& x) {
  if (!body.pad || x.isZero(0)) return 0;
  const Pad& pad = *body.pad;
  const PadSurface surface = pad_surface(body.mesh, pad);
  const Vec3 way = x.normalized();
  double pulling = 0, all = 0;
  for (const PadFacet& facet : surface.facets) {
    std::array<Vec3, 3> rest, moved;
    for (std::size_t i = 0; i < 3; ++i) {
      rest[i] = body.mesh.nodes[facet.corners[i]];
      moved[i] = Eigen::Map<const Vec3>(&displacements[3 * std::size_t{facet.corners[i]}]);
    }
    const Vec3 area = 0.5 * (rest[1] - rest[0]).cross(rest[2] - rest[0]);
    const double tau = std::clamp(2 * area.normalized().dot(surface.normal), 0.0, 1.0);
    const double weight = area.norm() * tau * tau * (3 - 2 * tau);  // springs by area, but for constants
    over_parts([&](const Vec3& l) {
      const Vec3 y = l[0] * rest[0] + l[1] * rest[1] + l[2] * rest[2];
      const Vec3 u = l[0] * moved[0] + l[1] * moved[1] + l[2] * moved[2];
      const double fall = std::max(0.0, 1 - (y - pad.site).squaredNorm() / (pad.radius * pad.radius));
      const double q = weight * fall * fall * (x - u).dot(way);
      pulling += std::max(0.0, -q);
      all += std::abs(q);
    });
  }
  return all > 0 ? pulling / all : 0;
}

}  // namespace forefeel
