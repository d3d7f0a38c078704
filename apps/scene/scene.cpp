#include "apps/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/console/suggest.hpp"
#include "apps/scene/cache_folder.hpp"
#include "apps/scene/option_names.hpp"
#include "apps/scene/scene_body.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/scene/scene_hand.hpp"
#include "apps/scene/scene_materials.hpp"
#include "apps/scene/scene_shape.hpp"
#include "apps/scene/scene_tolerance.hpp"
#include "apps/scene/spacing_check.hpp"
#include "apps/scene/spec_text.hpp"
#include "geometry/common/sha256.hpp"
#include "scheduling/workers/generator.hpp"
#include "solver/body/body_digest.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr double most_positions = 2e7;  // of a lattice; more come from a mistyped spacing

void check_positions(const StateSpaceOptions& space, const InputPlace& place) {
  const double positions = ((space.box.size() / space.spacing).array().floor() + 1).prod();
  if (positions > most_positions)
    throw InputError(place, fmt::format("gives {:.3g} positions in the box, expected at most {:g}", positions,
                                        most_positions));
}

constexpr double farthest = 100;  // longest sides of the body from rest: no force is meant there

// Refuses a spacing or a box that is too large, usually because of another unit or a mistyped exponent.
void check_reach(const SceneTable& table, const StateSpaceOptions& space, double side) {
  const double most = farthest * side;
  if (space.spacing > most)
    throw table.wrong("spacing",
                      fmt::format("at most {:.3g} m, {:g} times the body's longest side", most, farthest));
  if (!(space.box.low.cwiseAbs().maxCoeff() <= most && space.box.high.cwiseAbs().maxCoeff() <= most))
    throw InputError(table.where("box"),
                     fmt::format("reaches farther than {:.3g} m from rest, {:g} times the "
                                 "body's longest side; expected a box in metres",
                                 most, farthest));
}

void choose_spacing_of(const SceneTable& table, const SceneUse& use, Scene& scene) {
  if ((scene.space.box.size().array() <= 0).any())
    throw InputError(table.where("spacing"),
                     "is \"auto\" with a flat box, expected a box with a volume, or a number [m]");
  if (!use.spacing) {
    scene.space.spacing = finest_spacing(scene.space.box);
    return;
  }
  scene.spacing.chosen = automatic_spacing(scene.body, scene.identity,
                                           {.box = scene.space.box,
                                            .tolerance = scene.spacing.tolerance,
                                            .model = scene.model,
                                            .coverage = scene.space.coverage,
                                            .floor = scene.session.judging.error_floor},
                                           cache_folder(), use.quiet);
  scene.space.spacing = scene.spacing.chosen->spacing;
  if (!scene.spacing.chosen->holds)
    scene.source.warnings.push_back(fmt::format(
        "{}: no spacing that was tried makes safe mean an error below {:g} % in {:g} % of it; the finest is "
        "taken",
        table.where("spacing").text(), 100 * scene.spacing.tolerance,
        100 - 100 * scene.spacing.chosen->allowed_share));
}

void read_state_space(const SceneTable& table, const TetMesh& mesh, bool defaults, const SceneUse& use,
                      Scene& scene) {
  const bool automatic = scene.spacing.automatic = table.is_text("spacing", "auto");
  if (!defaults)
    for (const std::string key : {"spacing", "box"})
      if (!table.has(key))
        throw table.wrong(key, key == "box" ? "[[x0, y0, z0], [x1, y1, z1]]" : "a number above 0 [m]");
  const std::optional<Tolerance> tolerance = read_tolerance(table);
  if (tolerance && tolerance->newtons && automatic)
    throw table.wrong("tolerance", "a share of the force beside spacing = \"auto\", as 0.07");
  if (tolerance && !tolerance->newtons) scene.spacing.tolerance = tolerance->value;
  if (automatic)
    scene.space.spacing = longest_side(mesh) / 36;  // for a box that is not given
  else
    scene.space.spacing =
        table.number("spacing", {0, 1e300, true, false, "a number above 0 [m], or \"auto\""}).value_or(0.006);
  scene.space.box = table.has("box") ? *table.box("box") : default_box(mesh, scene.space.spacing);
  check_reach(table, scene.space, longest_side(mesh));
  if (automatic) choose_spacing_of(table, use, scene);
  if (!automatic || use.spacing) check_positions(scene.space, table.where("spacing"));
  if (const auto line =
          spacing_beyond(table.where("spacing").text(), scene.space.spacing, scene.space.box, "the states"))
    scene.source.warnings.push_back(*line);
  scene.displacements = table.boolean("displacements").value_or(false);
}

ModelOptions read_model(const SceneTable& table) {
  const ModelOptions usual = SessionModelOptions().fit;
  ModelOptions model = usual;
  model.kernel =
      table
          .word<Kernel>("kernel",
                        {{"linear", Kernel::linear}, {"cubic", Kernel::cubic}, {"quintic", Kernel::quintic}})
          .value_or(usual.kernel);
  model.data =
      table.word<Data>("data", {{"force", Data::force}, {"force+stiffness", Data::force_and_stiffness}})
          .value_or(model.kernel == Kernel::linear ? Data::force : usual.data);
  if (model.kernel == Kernel::linear && model.data == Data::force_and_stiffness)
    throw table.wrong("data", "\"force\" with the linear kernel, which has no derivative at a state");
  model.neighbours = static_cast<std::size_t>(
      table.integer("neighbours", 1, 100'000)
          .value_or(model.data == usual.data ? static_cast<std::int64_t>(usual.neighbours) : 100));
  model.select = table.word("select", select_words()).value_or(model.select);
  model.ridge = table.number("ridge", not_negative()).value_or(model.ridge);
  return model;
}

void read_switch(const SceneTable& session, SwitchOptions& options) {
  options.rule = session.word("switch", switch_words()).value_or(options.rule);
  const SceneTable jnd = session.sub("jnd", keys_of("session.jnd"));
  options.jnd_share = jnd.number("share", share()).value_or(options.jnd_share);
  options.jnd_floor = jnd.number("floor", positive()).value_or(options.jnd_floor);
}

void read_limits(const SceneTable& limits, SessionOptions& session) {
  session.safety.force_limit = limits.number("force", positive()).value_or(session.safety.force_limit);
  session.safety.slew_limit = limits.number("slew", positive()).value_or(session.safety.slew_limit);
  session.safety.ramp_seconds = limits.number("ramp", not_negative()).value_or(session.safety.ramp_seconds);
  session.safety.stale_seconds = limits.number("stale", positive()).value_or(session.safety.stale_seconds);
  session.safety.coupling = limits.number("coupling", positive());
}

std::optional<fs::path> file_beside(const SceneTable& table, const std::string& key, const fs::path& folder) {
  const std::optional<std::string> text = table.text(key);
  if (!text) return {};
  const fs::path path = folder / *text;
  if (!fs::exists(path)) throw InputError(table.where(key), fmt::format("no such file '{}'", path.string()));
  return path;
}

// A registered name, perhaps with settings: "mine:gain=2".
std::optional<Registered> part_of(const SceneTable& table, const std::string& key,
                                  const std::vector<std::string>& names) {
  const std::optional<std::string> text = table.text(key);
  if (!text) return {};
  Registered part = part_from_text(key, *text);
  chosen_word(table, key, part.name, names);
  return part;
}

void read_session(const SceneTable& table, const fs::path& folder, SessionOptions& session) {
  session.clock.kind = table.word("clock", clock_words()).value_or(session.clock.kind);
  session.clock.seconds = table.number("seconds", positive()).value_or(session.clock.seconds);
  session.planning.policy = part_of(table, "policy", policy_names()).value_or(session.planning.policy);
  session.motion.predictor =
      part_of(table, "predictor", predictor_names()).value_or(session.motion.predictor);
  session.workers.kind = part_of(table, "workers_kind", workers_names()).value_or(session.workers.kind);
  session.model.method = table.word("method", method_words()).value_or(session.model.method);
  session.planning.placement =
      table.word("placement", placement_words()).value_or(session.planning.placement);
  if (session.model.method != SessionMethod::rbf && session.planning.placement != Placement::lattice)
    throw table.wrong("placement",
                      fmt::format("lattice with method = \"{}\", which interpolates between lattice states",
                                  *table.text("method")));
  session.workers.count =
      static_cast<int>(table.integer("workers", 1, 100000).value_or(session.workers.count));
  read_switch(table, session.switching);
  session.model.update_travel =
      table.number("update_travel", positive()).value_or(session.model.update_travel);
  session.workers.latency = table.number("latency", not_negative()).value_or(session.workers.latency);
  session.planning.arrivals = file_beside(table, "arrivals", folder);
  session.planning.batch = static_cast<int>(table.integer("batch", 0, 8).value_or(session.planning.batch));
  session.workers.batch_share = table.number("batch_share", positive()).value_or(session.workers.batch_share);
  session.planning.rest_first = table.boolean("rest_first").value_or(session.planning.rest_first);
  session.model.first_guess = table.boolean("first_guess").value_or(session.model.first_guess);
  session.planning.rest_known = table.boolean("rest_known").value_or(session.planning.rest_known);
  session.planning.audit = table.number("audit", {.low = 0, .high = 0.5, .text = "from 0 to 0.5"})
                               .value_or(session.planning.audit);
  session.planning.preempt = table.boolean("preempt").value_or(session.planning.preempt);
  session.record = table.boolean("record").value_or(session.record);
  session.seed = static_cast<std::uint64_t>(table.integer("seed", 0, INT64_MAX).value_or(0));
  session.judging.error_floor = table.number("error_floor", positive()).value_or(session.judging.error_floor);
  session.judging.reference_step =
      table.number("reference_step", positive()).value_or(session.judging.reference_step);
  session.judging.visit_cell =
      table.number("visit_cell", not_negative()).value_or(session.judging.visit_cell);
  session.judging.visit_stride =
      static_cast<int>(table.integer("visit_stride", 1, 1000000).value_or(session.judging.visit_stride));
  session.safety.passivity = table.word("passivity", passivity_words()).value_or(session.safety.passivity);
  session.judging.discretisation_error =
      table.boolean("discretisation_error").value_or(session.judging.discretisation_error);
  read_limits(table.sub("limits", keys_of("session.limits")), session);
}

std::string hash_of(const SceneDocument& document, const BodyIdentity& identity) {
  Sha256 hash;
  hash.add(document.text());
  for (const auto& [key, value] : identity) hash.add(key + "=" + value + "\n");
  return hash.hex();
}

std::string body_source(const SceneDocument& document, const fs::path& file) {
  std::string text = file.string() + '\n';
  for (const char* section : {"body", "material", "clamp", "contact"})
    if (const std::optional<std::string> table = document.section_text(section))
      text += section + ("\n" + *table) + '\n';
  return text;
}

void take_body(Body body, Scene& scene) {
  scene.inward = inward_direction(body);
  scene.identity = identity_of(body);
  scene.body = std::make_shared<const Body>(std::move(body));
}

void share_body(const Scene& like, Scene& scene) {
  scene.inward = like.inward;
  scene.identity = like.identity;
  scene.body = like.body;
  scene.source.warnings.insert(scene.source.warnings.end(), like.source.warnings.begin(),
                               like.source.warnings.end());
}

constexpr const char* built_in = R"([body]
phantom = "liver"
[material]
law = "neo-hookean"
young = 5000.0
poisson = 0.45
[clamp]
group = "clamp"
[contact]
group = "contact"
[state_space]
spacing = 0.006
box = [[-0.036, -0.036, -0.036], [0.036, 0.036, 0.024]]
)";

Scene make_scene(const SceneDocument& document, const fs::path& file, const Scene* like,
                 const SceneUse& use = {}) {
  const SceneTable root = document.root(keys_of(""));
  const auto table = [&](const char* name) { return root.sub(name, keys_of(name)); };
  const SceneTable space = table("state_space"), model = table("model"), session = table("session");
  const BodySections sections{table("body"), root.subs("material", keys_of("material")), table("clamp"),
                              table("contact")};
  Scene scene;
  scene.source.file = file;
  scene.model = read_model(model);
  if (model.has("select") && session.has("select"))
    throw session.wrong("select", "only one of model.select and session.select");
  scene.model.select = session.word("select", select_words()).value_or(scene.model.select);
  read_session(session, file.parent_path(), scene.session);
  scene.written.device = session.text("device");
  const SceneTable hand = table("hand");
  const std::optional<std::string> of_hand = device_of_hand(hand);
  if (of_hand && scene.written.device)
    throw session.wrong("device", "only one of session.device and the table [hand]");
  if (of_hand) scene.written.device = of_hand;
  scene.written.cost = session.text("cost");
  scene.written.device_place = of_hand ? hand.place() : session.where("device");
  scene.written.cost_place = session.where("cost");
  scene.written.box_place = space.where("box");
  if (session.has("arrivals")) scene.written.arrivals_place = session.where("arrivals");
  for (const std::string& key : scheduling_keys())
    if (session.has(key)) scene.written.scheduling.emplace_back("session." + key, session.where(key));
  scene.source.body = body_source(document, file);
  if (like && like->source.body == scene.source.body)
    share_body(*like, scene);
  else
    take_body(read_body(sections, file.parent_path(), file.string(), scene.source.warnings), scene);
  scene.viscosity = read_viscosity(sections.materials);
  read_state_space(space, scene.body->mesh, sections.body.has("phantom"), use, scene);
  scene.displacements = scene.displacements || read_shape(session).rate > 0;
  scene.model.length = scene.space.spacing;
  scene.session.model.fit = scene.model;
  scene.source.hash = hash_of(document, scene.identity);
  return scene;
}

}  // namespace

Scene load_scene(const fs::path& file, std::span<const std::string> overrides, const Scene* like,
                 const SceneUse& use) {
  return make_scene(SceneDocument::read(file, overrides), file, like, use);
}

Scene built_in_scene(std::span<const std::string> overrides) {
  return make_scene(SceneDocument::parse(built_in, "liver phantom", overrides), "liver phantom", nullptr);
}

std::set<std::string> scene_keys_read(std::string_view text, std::span<const std::string> overrides) {
  const SceneDocument document = SceneDocument::parse(text, "scene", overrides);
  make_scene(document, "scene", nullptr, {.spacing = false});
  return document.keys_read();
}

StateSpaceOptions space_at(const Scene& scene, double spacing) {
  StateSpaceOptions space = scene.space;
  space.spacing = spacing;
  const bool box_given = scene.written.box_place.line > 0 || !scene.written.box_place.option.empty();
  if (!box_given) space.box = default_box(scene.body->mesh, spacing);
  check_positions(space, {.file = scene.source.file.string(), .key = "state_space.spacing"});
  return space;
}

std::string_view built_in_scene_text() {
  return built_in;
}

}  // namespace forefeel
