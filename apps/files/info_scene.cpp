#include "apps/files/info_scene.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "apps/console/json.hpp"
#include "apps/scene/scene.hpp"
#include "solver/body/contact_stiffness.hpp"
#include "solver/body/fine_jet.hpp"
#include "solver/body/pad.hpp"
#include "solver/body/pad_pull.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

struct Pull {
  double inward = unknown, oblique = unknown;
};

// The pulling share 10 mm along the inward normal, and 10 mm at 45 degrees to it.
Pull pull_of(const Scene& scene) {
  if (!scene.body->pad) return {};
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

Json contact_json(const Body& body, const Pull& pull) {
  Json contact{{"kind", body.pad ? "pad" : "rigid"}};
  const std::optional<PadSurface> under =
      body.pad ? std::optional(pad_surface(body.mesh, *body.pad)) : std::nullopt;
  contact["radius"] = body.pad ? number(body.pad->radius) : Json(nullptr);
  contact["pad"] = body.pad ? number(body.pad->stiffness) : Json(nullptr);
  contact["area"] = number(contact_area(body));
  contact["stiffness"] = under ? number(under->stiffness) : Json(nullptr);
  contact["pulling_share"] = under ? json_numbers({pull.inward, pull.oblique}) : Json(nullptr);
  contact["clamped_share"] = under ? number(clamped_share(body, *under)) : Json(nullptr);
  if (!body.pad) contact["nodes"] = body.contact.size();
  return contact;
}

Json fine_json(const Body& body) {
  if (!body.fine) return nullptr;
  return {{"body", body.fine->fine_body()}, {"radius", number(body.fine->radius())}};
}

}  // namespace

int info_scene(const Globals& globals, const std::string& file) {
  const Scene scene = load_scene(file, globals.set, nullptr, {.spacing = false, .quiet = globals.quiet});
  const Body& body = *scene.body;
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  const Pull pull = pull_of(scene);
  if (globals.json)
    print_json({{"kind", "scene"},
                {"element", name(body.element)},
                {"elements", body.mesh.tets.size()},
                {"nodes", body.mesh.nodes.size()},
                {"clamped_nodes", body.clamp.size()},
                {"contact", contact_json(body, pull)},
                {"fine", fine_json(body)},
                {"identity", Json(scene.identity)},
                {"warnings", scene.source.warnings}});
  answer(globals, fmt::format("{}: {} {} elements, {} nodes, {} of them clamped", file, body.mesh.tets.size(),
                              name(body.element), body.mesh.nodes.size(), body.clamp.size()));
  if (body.pad) {
    const PadSurface under = pad_surface(body.mesh, *body.pad);
    answer(globals,
           fmt::format(
               "  contact: a pad of {:g} N/m and {:g} mm over {:.3g} cm2; its springs amount to {:.4g} N/m",
               body.pad->stiffness, 1e3 * body.pad->radius, 1e4 * under.area, under.stiffness));
    answer(globals,
           fmt::format("  pressed in by 10 mm, {:.2g} % of its springs' force pulls; at 45 degrees {:.2g} %",
                       100 * pull.inward, 100 * pull.oblique));
  } else {
    answer(globals, fmt::format("  contact: {} nodes that move with the tip, {:.3g} cm2", body.contact.size(),
                                1e4 * contact_area(body)));
  }
  if (body.fine)
    answer(globals, fmt::format("  corrected by a fine body ({}), fully to {:.3g} mm from rest",
                                body.fine->fine_body(), 1e3 * FineJet::trusted_share * body.fine->radius()));
  return 0;
}

}  // namespace forefeel
