#pragma once
// Blocks of tetrahedra made by code: each cube of an nx x ny x nz grid is cut into six along its diagonal.

#include "solver/equilibrium/solver.hpp"
#include "tests/support/test.hpp"

namespace forefeel {

inline TetMesh block_mesh(int nx, int ny, int nz, const Vec3& size) {
  TetMesh mesh;
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        mesh.nodes.emplace_back(size[0] * i / nx, size[1] * j / ny, size[2] * k / nz);
  const auto node = [&](int i, int j, int k) {
    return static_cast<NodeIndex>((k * (ny + 1) + j) * (nx + 1) + i);
  };
  // The six paths from corner 0 to corner 7 along the axes. The parity of the order of axes is the sign of the volume.
  const int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (int o = 0; o < 6; ++o) {
          int at[3] = {i, j, k};
          Tet tet{};
          tet[0] = node(at[0], at[1], at[2]);
          for (std::size_t s = 0; s < 3; ++s) {
            ++at[orders[o][s]];
            tet[s + 1] = node(at[0], at[1], at[2]);
          }
          if (o >= 3) std::swap(tet[1], tet[2]);
          mesh.tets.push_back(tet);
        }
  return mesh;
}

// A block 10 x 4 x 4 cm, clamped at x = 0, touched by the nodes at x = 10 cm, y = 4 cm.
inline std::shared_ptr<Body> block_body(Law law, double poisson = 0.4, int refine = 1,
                                        Element element = Element::linear) {
  auto body = std::make_shared<Body>();
  body->mesh = block_mesh(5 * refine, 2 * refine, 2 * refine, Vec3(0.1, 0.04, 0.04));
  body->material = {law, 5000, poisson};
  body->element = element;
  for (std::size_t i = 0; i < body->mesh.nodes.size(); ++i) {
    const Vec3& x = body->mesh.nodes[i];
    if (x[0] < 1e-9) body->clamp.push_back(static_cast<NodeIndex>(i));
    if (x[0] > 0.1 - 1e-9 && x[1] > 0.04 - 1e-9) body->contact.push_back(static_cast<NodeIndex>(i));
  }
  return body;
}

// The state at x, checked with central differences: its force is minus the gradient of the energy, its stiffness minus
// the derivative of the force within a share of it, and symmetric.
inline State check_derivatives(Solver& solver, const Vec3& x, double share,
                               const SolveOptions& options = {}) {
  const auto state_at = [&](const Vec3& place) { return solver.reference(place, 0.006, options).state; };
  const State at = state_at(x);
  REQUIRE(at.solve.status == SolveStatus::converged);
  const double h = 1e-5;
  Mat3 stiffness;
  Vec3 force;
  for (int j = 0; j < 3; ++j) {
    const State up = state_at(x + h * Vec3::Unit(j)), down = state_at(x - h * Vec3::Unit(j));
    stiffness.col(j) = -(up.force - down.force) / (2 * h);
    force[j] = -(up.energy - down.energy) / (2 * h);
  }
  CHECK((at.stiffness - stiffness).norm() < share * stiffness.norm());
  CHECK((at.stiffness - at.stiffness.transpose()).norm() < 1e-12 * stiffness.norm());
  CHECK((at.force - force).norm() < 1e-6 * force.norm());
  return at;
}

}  // namespace forefeel
