// First force: a body, exact states on a small lattice, and a model that answers in microseconds.

#include <fmt/format.h>
#include <forefeel/forefeel.hpp>

using namespace forefeel;

int main() {
  // 1. The body: a soft beam of 10 x 2 x 2 cm, clamped at one end, grasped at the other.
  const TetMesh mesh = phantom("beam", 240);
  const Body beam{.mesh = mesh,
                  .material = {.law = Law::neo_hookean, .young = 5000, .poisson = 0.3},  // [Pa], [1]
                  .clamp = mesh.groups.at("clamp"),
                  .contact = mesh.groups.at("contact")};

  // 2. The states: static equilibria with the contact moved to each point of a lattice around rest.
  StateSpace space({.spacing = 0.004, .box = {Vec3::Constant(-0.008), Vec3::Constant(0.008)}});  // [m]
  generate(beam, space);
  fmt::print("states: {}\n", space.size());

  // 3. The model: radial basis functions through the 25 nearest states and their stiffness.
  ModelUpdater updater(space,
                       {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25});
  const Vec3 x(0.001, 0.003, -0.005);  // contact moved from rest [m]
  const Vec3 force = updater.model_at(x).force(x);

  // 4. The exact force beside it. Forces are those of the body on the hand [N].
  const Vec3 exact = Solver(beam).reference(x, space.options().spacing).state.force;
  fmt::print("force: {:.5f} {:.5f} {:.5f} N\n", force.x(), force.y(), force.z());
  fmt::print("relative error: {:.1e}\n", (force - exact).norm() / exact.norm());
}
