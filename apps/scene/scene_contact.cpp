#include "apps/scene/scene_contact.hpp"

#include <Eigen/Geometry>

#include "solver/body/contact_stiffness.hpp"
#include "solver/body/pad.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {
namespace {

// 10 mm along the inward normal, and 10 mm at 45 degrees to it.
std::array<double, 2> pull_of(const Scene& scene) {
  constexpr double distance = 0.01;
  Solver solver(scene.body);
  SolveOptions options;
  options.want_displacements = true;
  const auto share = [&](const Vec3& x) {
    const State state = solver.reference(x, scene.space.spacing, options).state;
    return state.usable() ? pulling_share(*scene.body, *state.displacements, x) : unknown;
  };
  const Vec3 n = scene.inward.normalized();
  return {share(distance * n), share(distance * (n + n.unitOrthogonal()).normalized())};
}

}  // namespace

ContactNote contact_note(const Scene& scene) {
  const Body& body = *scene.body;
  ContactNote note;
  if (scene.touch.anywhere) {
    note.pad = true;
    note.radius = body.pad->radius;
    note.stiffness = body.pad->stiffness;
    return note;
  }
  note.area = contact_area(body);
  note.place = {rest_of_contact(body), -scene.inward.normalized()};
  if (!body.pad) {
    note.nodes = body.contact.size();
    return note;
  }
  const PadSurface under = pad_surface(body.mesh, *body.pad);
  note.pad = true;
  note.radius = body.pad->radius;
  note.stiffness = body.pad->stiffness;
  note.springs = under.stiffness;
  note.pulling_share = pull_of(scene);
  note.clamped_share = clamped_share(body, under);
  return note;
}

}  // namespace forefeel
