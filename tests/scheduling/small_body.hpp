#pragma once
// A beam of a few tetrahedra, 8 x 2 x 2 cm, clamped at x = 0 and touched at the free end. A solve takes well
// under a millisecond. Sideways forces are a fraction of a newton, axial forces some newtons.

#include <unistd.h>

#include "scheduling/session/session.hpp"
#include "solver/body/body.hpp"
#include "tests/support/test.hpp"

namespace forefeel::test {

inline TetMesh beam_mesh(int cells_x = 4, int cells_y = 1, int cells_z = 1) {
  TetMesh mesh;
  const auto node = [&](int i, int j, int k) {
    return static_cast<NodeIndex>((i * (cells_y + 1) + j) * (cells_z + 1) + k);
  };
  for (int i = 0; i <= cells_x; ++i)
    for (int j = 0; j <= cells_y; ++j)
      for (int k = 0; k <= cells_z; ++k)
        mesh.nodes.emplace_back(0.08 * i / cells_x, 0.02 * j / cells_y, 0.02 * k / cells_z);
  // Kuhn's six tetrahedra along the main diagonal of each brick.
  constexpr int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (int i = 0; i < cells_x; ++i)
    for (int j = 0; j < cells_y; ++j)
      for (int k = 0; k < cells_z; ++k)
        for (const auto& order : orders) {
          std::array<int, 3> at{i, j, k};
          Tet tet{node(i, j, k), 0, 0, 0};
          for (int step = 0; step < 3; ++step) {
            ++at[static_cast<std::size_t>(order[step])];
            tet[static_cast<std::size_t>(step + 1)] = node(at[0], at[1], at[2]);
          }
          mesh.tets.push_back(tet);
        }
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    if (tet_volume(mesh, t) < 0) std::swap(mesh.tets[t][2], mesh.tets[t][3]);
  return mesh;
}

inline std::shared_ptr<const Body> small_body(Law law = Law::neo_hookean) {
  auto body = std::make_shared<Body>();
  body->mesh = beam_mesh();
  body->material = {.law = law, .young = 2e5, .poisson = 0.3};
  for (NodeIndex i = 0; i < 4; ++i) body->clamp.push_back(i);
  for (NodeIndex i = 16; i < 20; ++i) body->contact.push_back(i);
  return body;
}

// A block of 6 x 6 x 4 cm, clamped at its bottom, with nine contact nodes in the middle of its top, where it is finer.
inline std::shared_ptr<const Body> block_body() {
  auto body = std::make_shared<Body>();
  body->mesh = beam_mesh(6, 6, 4);
  body->material = {.law = Law::neo_hookean, .young = 2e5, .poisson = 0.3};
  constexpr double side[] = {-0.03, -0.014, -0.006, 0, 0.006, 0.014, 0.03};
  constexpr double height[] = {0, 0.018, 0.028, 0.034, 0.04};
  for (std::size_t i = 0; i < body->mesh.nodes.size(); ++i) {
    Vec3& x = body->mesh.nodes[i];
    x = Vec3(side[i / 35], side[i / 5 % 7], height[i % 5]);
    if (i % 5 == 0) body->clamp.push_back(static_cast<NodeIndex>(i));
    if (i % 5 == 4 && x.head<2>().norm() < 0.009) body->contact.push_back(static_cast<NodeIndex>(i));
  }
  return body;
}

// Box of 24 mm about rest, spacing 6 mm: 5 x 5 x 5 lattice states.
inline SessionInput small_input(Law law = Law::neo_hookean) {
  SessionInput input;
  input.touched.body = small_body(law);
  input.touched.identity = {{"mesh", "small beam"},
                            {"material", law == Law::linear ? "linear" : "neo-hookean"}};
  input.touched.space.spacing = 0.006;
  input.touched.space.box = {Vec3::Constant(-0.012), Vec3::Constant(0.012)};
  return input;
}

// The same with the block.
inline SessionInput block_input() {
  SessionInput input = small_input();
  input.touched.body = block_body();
  input.touched.identity = {{"mesh", "small block"}, {"material", "neo-hookean"}};
  return input;
}

inline SessionOptions virtual_options(double seconds = 1) {
  SessionOptions options;
  options.clock.kind = Clock::virtual_time;
  options.clock.seconds = seconds;
  options.motion.device = PathMotion{.path = PathName::tour, .speed = 0.06};
  options.model.fit = {.neighbours = 30};
  options.planning.audit = 0;  // every solve is the policy's
  return options;
}

inline void expect_no_state_twice(const SessionResult& result) {
  std::set<std::tuple<double, double, double>> solved;
  for (const DispatchRecord& d : result.dispatch)
    if (d.status == DispatchStatus::solved) REQUIRE(solved.insert({d.at.x(), d.at.y(), d.at.z()}).second);
}

}  // namespace forefeel::test
