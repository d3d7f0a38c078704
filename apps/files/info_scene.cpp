#include "apps/files/info_scene.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "apps/console/json.hpp"
#include "apps/scene/scene.hpp"
#include "apps/scene/scene_contact.hpp"
#include "solver/body/fine_jet.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

Json fine_json(const Body& body) {
  if (!body.fine) return nullptr;
  return {{"body", body.fine->fine_body()}, {"radius", number(body.fine->radius())}};
}

}  // namespace

int info_scene(const Globals& globals, const std::string& file) {
  const Scene scene = load_scene(file, globals.set, nullptr, {.spacing = false, .quiet = globals.quiet});
  const Body& body = *scene.body;
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  const ContactNote contact = contact_note(scene);
  if (globals.json)
    print_json({{"kind", "scene"},
                {"element", name(body.element)},
                {"elements", body.mesh.tets.size()},
                {"nodes", body.mesh.nodes.size()},
                {"clamped_nodes", body.clamp.size()},
                {"contact", document_of(contact_keys(), contact)},
                {"fine", fine_json(body)},
                {"accuracy", scene.source.accuracy ? Json(in_words(*scene.source.accuracy)) : Json()},
                {"identity", Json(scene.identity)},
                {"warnings", scene.source.warnings}});
  answer(globals, fmt::format("{}: {} {} elements, {} nodes, {} of them clamped", file, body.mesh.tets.size(),
                              name(body.element), body.mesh.nodes.size(), body.clamp.size()));
  if (contact.pad) {
    answer(globals,
           fmt::format(
               "  contact: a pad of {:g} N/m and {:g} mm over {:.3g} cm2; its springs amount to {:.4g} N/m",
               contact.stiffness, 1e3 * contact.radius, 1e4 * contact.area, contact.springs));
    answer(globals,
           fmt::format("  pressed in by 10 mm, {:.2g} % of its springs' force pulls; at 45 degrees {:.2g} %",
                       100 * contact.pulling_share[0], 100 * contact.pulling_share[1]));
  } else {
    answer(globals, fmt::format("  contact: {} nodes that move with the tip, {:.3g} cm2", body.contact.size(),
                                1e4 * contact.area));
  }
  if (scene.source.accuracy) answer(globals, "  body.accuracy: " + in_words(*scene.source.accuracy));
  if (body.fine)
    answer(globals, fmt::format("  corrected by a fine body ({}), fully to {:.3g} mm from rest",
                                body.fine->fine_body(), 1e3 * FineJet::trusted_share * body.fine->radius()));
  return 0;
}

}  // namespace forefeel
