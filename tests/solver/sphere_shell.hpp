#pragma once
// A body between two concentric rigid spheres of radii a < b, the outer one clamped, the inner one the contact. For
// linear elasticity its stiffness is known. With the angle t to the displacement U, u_r = f(r) U cos t, u_t = -g(r) U
// sin t, and
//   f = A + 4 (1 - v) C / r - 2 D / r^3 + (1 - 4 v) E r^2
//   g = A + (3 - 4 v) C / r + D / r^3 - (3 - 2 v) E r^2
// solve Navier's equations; f = g = 1 at a and 0 at b give the constants. Only the term of Kelvin's point force carries
// a force:
//   F = 16 pi mu (1 - v) C U                                                                                    [N]

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <utility>

#include "solver/body/body.hpp"

namespace forefeel {

inline double shell_stiffness(double a, double b, double young, double v) {
  Eigen::Matrix4d left;
  for (int end = 0; end < 2; ++end) {
    const double r = end == 0 ? a : b;
    left.row(2 * end) << 1, 4 * (1 - v) / r, -2 / (r * r * r), (1 - 4 * v) * r * r;
    left.row(2 * end + 1) << 1, (3 - 4 * v) / r, 1 / (r * r * r), -(3 - 2 * v) * r * r;
  }
  const double c = left.colPivHouseholderQr().solve(Eigen::Vector4d(1, 1, 0, 0))[1];
  return 16 * std::numbers::pi * (young / (2 * (1 + v))) * (1 - v) * c;
}

// The unit octahedron with each triangle in four, `times` times; all nodes on the unit sphere.
struct UnitSphere {
  std::vector<Vec3> nodes{Vec3::UnitX(),  -Vec3::UnitX(), Vec3::UnitY(),
                          -Vec3::UnitY(), Vec3::UnitZ(),  -Vec3::UnitZ()};
  std::vector<Triangle> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                  {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};

  explicit UnitSphere(int times) {
    for (int k = 0; k < times; ++k) {
      std::map<std::pair<NodeIndex, NodeIndex>, NodeIndex> middles;
      const auto middle = [&](NodeIndex i, NodeIndex j) {
        const auto [at, is_new] = middles.emplace(std::minmax(i, j), static_cast<NodeIndex>(nodes.size()));
        if (is_new)
          nodes.push_back(
              (nodes[static_cast<std::size_t>(i)] + nodes[static_cast<std::size_t>(j)]).normalized());
        return at->second;
      };
      std::vector<Triangle> finer;
      for (const auto& [i, j, l] : triangles) {
        const NodeIndex m = middle(i, j), n = middle(j, l), o = middle(l, i);
        finer.insert(finer.end(), {{i, m, o}, {m, j, n}, {o, n, l}, {m, n, o}});
      }
      triangles = std::move(finer);
    }
  }
};

inline std::shared_ptr<Body> sphere_shell(int times, int layers, double a, double b,
                                          const Material& material) {
  const UnitSphere sphere(times);
  auto body = std::make_shared<Body>();
  body->material = material;
  const auto n = static_cast<NodeIndex>(sphere.nodes.size());
  for (int layer = 0; layer <= layers; ++layer)
    for (const Vec3& x : sphere.nodes) body->mesh.nodes.push_back((a + (b - a) * layer / layers) * x);
  for (NodeIndex i = 0; i < n; ++i) body->contact.push_back(i), body->clamp.push_back(n * layers + i);
  for (int layer = 0; layer < layers; ++layer)
    for (Triangle t : sphere.triangles) {
      std::ranges::sort(t);  // so that neighbouring prisms cut their common face alike
      for (NodeIndex& node : t) node += n * layer;
      for (Tet tet : {Tet{t[0], t[1], t[2], t[2] + n}, Tet{t[0], t[1], t[1] + n, t[2] + n},
                      Tet{t[0], t[0] + n, t[1] + n, t[2] + n}}) {
        body->mesh.tets.push_back(tet);
        if (tet_volume(body->mesh, body->mesh.tets.size() - 1) < 0)
          std::swap(body->mesh.tets.back()[2], body->mesh.tets.back()[3]);
      }
    }
  return body;
}

}  // namespace forefeel
