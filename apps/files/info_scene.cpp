#include "apps/files/info_scene.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "apps/console/json.hpp"
#include "apps/console/outputs.hpp"
#include "apps/scene/palpation_map.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_contact.hpp"
#include "solver/body/fine_jet.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

Json fine_json(const Scene& scene) {
  const Body& body = *scene.body;
  if (scene.touch.anywhere && scene.touch.anywhere->fine)
    return {{"body", scene.identity.at("fine")}, {"radius", nullptr}};
  if (!body.fine) return nullptr;
  return {{"body", body.fine->fine_body()}, {"radius", number(body.fine->radius())}};
}

}  // namespace

int info_scene(const Globals& globals, const std::string& file) {
  const Scene scene = load_scene_with_sites(file, globals.set, {.spacing = false, .quiet = globals.quiet});
  const Body& body = *scene.body;
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  const ContactNote contact = contact_note(scene);
  std::optional<FieldNote> field;
  if (is_anywhere(scene)) field = field_note(scene, find_field(scene, globals), globals);
  if (globals.json)
    print_json({{"kind", "scene"},
                {"element", name(body.element)},
                {"elements", body.mesh.tets.size()},
                {"nodes", body.mesh.nodes.size()},
                {"clamped_nodes", body.clamp.size()},
                {"contact", document_of(contact_keys(), contact)},
                {"field", field ? document_of(field_keys(), *field) : Json()},
                {"fine", fine_json(scene)},
                {"accuracy", scene.source.accuracy ? Json(in_words(*scene.source.accuracy)) : Json()},
                {"identity", Json(scene.identity)},
                {"warnings", scene.source.warnings}});
  answer(globals, fmt::format("{}: {} {} elements, {} nodes, {} of them clamped", file, body.mesh.tets.size(),
                              name(body.element), body.mesh.nodes.size(), body.clamp.size()));
  if (field) {
    answer(globals, fmt::format("  contact: a pad of {:g} N/m and {:g} mm, anywhere", contact.stiffness,
                                1e3 * contact.radius));
    for (const std::string& line : in_words(*field)) answer(globals, "  " + line);
  } else if (contact.pad) {
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
  if (field && scene.touch.anywhere->fine)
    answer(globals, fmt::format("  the field is that of a fine body ({})", scene.identity.at("fine")));
  if (body.fine)
    answer(globals, fmt::format("  corrected by a fine body ({}), fully to {:.3g} mm from rest",
                                body.fine->fine_body(), 1e3 * FineJet::trusted_share * body.fine->radius()));
  return 0;
}

DeclaredTable info_scene_output() {
  DeclaredTable table{"info.json", "Of info SCENE --json, beside what its lines say.", {}};
  for (const std::vector<Declared>& rows :
       {below("contact", declared(contact_keys())), below("field", declared(field_keys()))})
    table.rows.insert(table.rows.end(), rows.begin(), rows.end());
  return table;
}

}  // namespace forefeel
