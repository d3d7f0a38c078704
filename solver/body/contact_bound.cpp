#include "solver/body/contact_bound.hpp"
#include "solver/body/pad.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace forefeel {
namespace {

Mat3 stiffness_of(const TetMesh& mesh, const Tet& tet, const std::array<bool, 4>& moves,
                  const Material& material) {
  const auto node = [&](std::size_t i) -> const Vec3& { return mesh.nodes[tet[i]]; };
  Mat3 edges;
  for (unsigned i = 0; i < 3; ++i) edges.col(i) = node(i + 1) - node(0);
  const Mat3 gradients = edges.inverse();  // row i: grad N_(i + 1)
  Vec3 g = Vec3::Zero();
  for (unsigned i = 0; i < 3; ++i) {
    const Vec3 own = gradients.row(i);
    if (moves[i + 1]) g += own;
    if (moves[0]) g -= own;
  }
  const double e = material.young, nu = material.poisson;
  const double mu = e / (2 * (1 + nu)), lambda = e * nu / ((1 + nu) * (1 - 2 * nu));
  const double volume = std::abs(edges.determinant()) / 6;
  return volume * ((lambda + mu) * g * g.transpose() + mu * g.squaredNorm() * Mat3::Identity());
}

}  // namespace

Mat3 contact_stiffness_bound(const Body& body) {
  if (body.pad) return pad_surface(body.mesh, *body.pad).stiffness * Mat3::Identity();
  std::vector<bool> in_contact(body.mesh.nodes.size(), false);
  for (const NodeIndex node : body.contact) in_contact[node] = true;
  Mat3 sum = Mat3::Zero();
  for (const MaterialPart& part : material_parts(body))
    for (const TetIndex t : part.tets) {
      const Tet& tet = body.mesh.tets[t];
      std::array<bool, 4> moves{};
      for (std::size_t i = 0; i < 4; ++i) moves[i] = in_contact[tet[i]];
      const auto moving = std::ranges::count(moves, true);
      if (moving > 0 && moving < 4) sum += stiffness_of(body.mesh, tet, moves, part.material);
    }
  return sum;
}

}  // namespace forefeel
