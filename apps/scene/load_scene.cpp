#include "apps/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/console/spacing_check.hpp"
#include "apps/scene/cache_folder.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_body.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/scene/scene_fine.hpp"
#include "apps/scene/scene_hand.hpp"
#include "apps/scene/scene_materials.hpp"
#include "apps/scene/scene_nodes.hpp"
#include "apps/scene/scene_spacing.hpp"
#include "apps/scene/session_rows.hpp"
#include "geometry/common/sha256.hpp"
#include "geometry/states/energy_jet.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/workers/generator.hpp"
#include "solver/body/body_digest.hpp"
#include "solver/jet/rest_jet.hpp"

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
  scene.space.spacing = scene.spacing.chosen->found.spacing;
  if (!scene.spacing.chosen->holds)
    scene.source.warnings.push_back(fmt::format(
        "{}: no spacing that was tried makes safe mean an error below {:g} % in {:g} % of it; the finest is "
        "taken",
        table.where("spacing").text(), 100 * scene.spacing.tolerance,
        100 - 100 * scene.spacing.chosen->allowed_share));
}

void read_design(const SceneTable& table, const std::string& key, Scene& scene) {
  constexpr std::string_view of_list = "list:";
  const std::string text = table.holds_text(key) ? *table.text(key) : "";
  if (!text.starts_with(of_list)) {
    scene.space.design = *table.word(key, design_words);
    return;
  }
  const fs::path file = scene.source.file.parent_path() / text.substr(of_list.size());
  if (!fs::is_regular_file(file))
    throw InputError(table.where(key), fmt::format("no such file '{}', expected rows x,y,z", file.string()));
  scene.space.design = Design::listed;
  scene.space.listed = std::make_shared<const std::vector<Vec3>>(read_points_csv(file));
  check_listed(scene.space, file.string());
}

const SceneRows<Scene>& rows_of_space() {
  static const auto rows =
      SceneRows<Scene>("state_space", "Where states are placed.")
          .row({"spacing", "m", "",
                "distance between states that counts as dense, and side of generated lattices; \"auto\": "
                "measured, so that safe means an error below "
                "tolerance"})
          .required("a number above 0 [m]")
          .standard("required; 0.006 with a phantom")
          .row({"box", "m", "",
                "[[x0, y0, z0], [x1, y1, z1]] of tip positions, low corner first; rest is [0, 0, 0]"})
          .required("[[x0, y0, z0], [x1, y1, z1]]")
          .standard("required; made of the body with a phantom")
          .row({"design", "", "lattice",
                in_words(design_words) + " or list:FILE (CSV x,y,z in m): how generate, and sessions with "
                                         "placement = \"lattice\", fill "
                                         "the box; all but a list with a state for each spacing^3. error: of "
                                         "generate alone, each next "
                                         "state where the estimated error is largest"},
               read_design)
          .row({"depth", "m", fmt::format("{}", usual_depth),
                "with contact.anywhere, in place of box: how deep states are placed, and half as far "
                "sideways"})
          .flag("displacements", "true: states keep the displacements of all nodes",
                path(&Scene::kept, &KeptValues::displacements))
          .whole("jet", 1, most_jet_order,
                 "order of the force that a state keeps, about its position: 1, force and stiffness; 2 to 4, "
                 "also an "
                 "energy jet",
                 path(&Scene::kept, &KeptValues::jet))
          .standard("1; 4 with model.data = \"jet\"")
          .row({"tolerance", "1", fmt::format("{}", usual_tolerance),
                "error that spacing = \"auto\" allows where safe, and within which session and classify "
                "--bars "
                "say the force is known: a share of the force, or \"0.07 N\""});
  return rows;
}

void read_state_space(const SceneTable& table, const TetMesh& mesh, bool defaults, const SceneUse& use,
                      Scene& scene) {
  const std::optional<AnywhereKeys>& anywhere = scene.touch.anywhere;
  const bool automatic = scene.spacing.automatic = table.is_text("spacing", "auto");
  if (!defaults && !anywhere) rows_of_space().check_required(table);
  const std::optional<Tolerance>& tolerance = scene.written.tolerance = read_tolerance(table);
  if (tolerance && tolerance->newtons && automatic)
    throw table.wrong("tolerance", "a share of the force beside spacing = \"auto\", as 0.07");
  if (tolerance && !tolerance->newtons) scene.spacing.tolerance = tolerance->value;
  if (automatic)
    scene.space.spacing = longest_side(mesh) / 36;  // for a box that is not given
  else
    scene.space.spacing =
        table.number("spacing", {0, 1e300, true, false, "a number above 0 [m], or \"auto\""}).value_or(0.006);
  if (anywhere && anywhere->depth > longest_side(mesh))
    throw table.wrong("depth", fmt::format("at most {:.3g} m, the body's longest side", longest_side(mesh)));
  if (anywhere)  // the cube that holds every displacement of a touch of this depth, in the frame of any site
    scene.space.box = {Vec3::Constant(-anywhere->depth), Vec3::Constant(anywhere->depth)};
  else
    scene.space.box = table.has("box") ? *table.box("box") : default_box(mesh, scene.space.spacing);
  check_reach(table, scene.space, longest_side(mesh));
  if (automatic) choose_spacing_of(table, use, scene);
  if (!automatic || use.spacing) check_positions(scene.space, table.where("spacing"));
  if (const auto line =
          spacing_beyond(table.where("spacing").text(), scene.space.spacing, scene.space.box, "the states"))
    scene.source.warnings.push_back(*line);
  rows_of_space().read(table, scene);
}

const SceneRows<ModelOptions>& rows_of_model() {
  using M = ModelOptions;
  static const auto rows =
      SceneRows<M>("model", "The interpolation of the force between states.", SessionModelOptions().fit)
          .word("kernel", kernel_words, ": radial basis function of order 1, 3, 5", &M::kernel)
          .word("data", data_words, ": what is fitted", &M::data)
          .standard("force+stiffness; force with the linear kernel")
          .whole("neighbours", 1, 100'000, "states of a model", &M::neighbours)
          .standard("25; 100 with data = \"force\"; 8 with data = \"jet\"")
          .word("select", select_words, ": rule that chooses the neighbours", &M::select)
          .number("ridge", "1", not_negative(),
                  "smoothing for noisy states, added to the kernel's diagonal; 0: none", &M::ridge);
  return rows;
}

ModelOptions read_model(const SceneTable& table) {
  const ModelOptions usual = SessionModelOptions().fit;
  ModelOptions model = usual;
  rows_of_model().read(table, model);
  if (model.kernel == Kernel::linear && !table.has("data")) model.data = Data::force;
  if (model.kernel == Kernel::linear && model.data != Data::force)
    throw table.wrong("data", "\"force\" with the linear kernel, which has no derivative at a state");
  if (!table.has("neighbours")) model.neighbours = usual_neighbours(model.data);
  return model;
}

std::string hash_of(const SceneDocument& document, const BodyIdentity& identity,
                    const StateSpaceOptions& space) {
  Sha256 hash;
  hash.add(document.text());
  if (space.listed)
    for (const Vec3& at : *space.listed)
      for (const double c : at) hash.add(c);
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

// A body whose pad has no place.
void take_place(std::shared_ptr<const FineBodies> fine, Scene& scene) {
  scene.identity["contact"] = anywhere_in_words(*scene.body->pad);
  if (fine) scene.identity["fine"] = fine_body_in_words(fine->first);
  scene.touch.anywhere->fine = std::move(fine);
}

void share_body(const Scene& like, Scene& scene) {
  if (scene.touch.anywhere && like.touch.anywhere) scene.touch.anywhere->fine = like.touch.anywhere->fine;
  scene.inward = like.inward;
  scene.identity = like.identity;
  scene.body = like.body;
  scene.source.accuracy = like.source.accuracy;
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

// Keys of the models and lattices of one place.
void warn_of_one_place(const SceneTable& model, const SceneTable& session, const SceneTable& contact,
                       Scene& scene) {
  const auto warn = [&](const SceneTable& table, const std::string& key) {
    if (table.has(key))
      scene.source.warnings.push_back(table.where(key).text() + ": without effect with contact.anywhere");
  };
  warn(contact, "nearest");
  for (const std::string& key : model_rows().names()) warn(model, key);
  for (const char* key : {"method", "placement", "select", "rest_first"}) warn(session, key);
}

// sites: of a command that knows places on the surface.
Scene make_scene(const SceneDocument& document, const fs::path& file, const Scene* like,
                 const SceneUse& use = {}, bool sites = false) {
  const SceneTable root = document.root(scene_sections());
  const auto table = [&](const SceneRowList& rows) { return root.sub(rows.name(), rows.names()); };
  const SceneTable space = table(state_space_rows()), model = table(model_rows()),
                   session = table(session_rows());
  BodySections sections{table(body_rows()), root.subs("material", material_rows().names()),
                        table(clamp_rows()), table(contact_rows())};
  Scene scene;
  scene.touch.anywhere = read_anywhere(sections.contact, space, scene.source.warnings);
  if (scene.touch.anywhere && !sites)
    throw InputError(sections.contact.where("anywhere"),
                     "is for solve --site, generate, evaluate, classify, session, info and show, expected "
                     "nearest = [x, y, z], a place for the pad, with this command");
  scene.source.file = file;
  scene.model = read_model(model);
  if (model.has("select") && session.has("select"))
    throw session.wrong("select", "only one of model.select and session.select");
  read_session(session, scene);
  if (scene.touch.anywhere) warn_of_one_place(model, session, sections.contact, scene);
  const SceneTable hand = table(hand_rows());
  const std::optional<std::string> of_hand = device_of_hand(hand);
  if (of_hand && scene.written.device)
    throw session.wrong("device", "only one of session.device and the table [hand]");
  if (of_hand) scene.written.device = of_hand;
  if (of_hand) scene.written.device_place = hand.place();
  scene.written.box_place = space.where("box");
  scene.source.body = sections.text = body_source(document, file);
  if (like && like->source.body == scene.source.body) {
    share_body(*like, scene);
  } else {
    BodyRead read = read_body(sections, file.parent_path(), file.string(), use.quiet, scene.source.warnings);
    scene.source.accuracy = std::move(read.accuracy);
    take_body(std::move(read.body), scene);
    if (scene.touch.anywhere) take_place(std::move(read.fine), scene);
  }
  scene.touch.viscosity = read_viscosity(sections.materials);
  read_state_space(space, scene.body->mesh, sections.body.has("phantom"), use, scene);
  if (scene.model.data == Data::jet && !space.has("jet")) scene.kept.jet = most_jet_order;
  scene.kept.displacements = scene.kept.displacements || scene.shape.rate > 0;
  scene.model.length = scene.space.spacing;
  scene.session.model.fit = scene.model;
  scene.source.hash = hash_of(document, scene.identity, scene.space);
  return scene;
}

}  // namespace

const SceneRowList& state_space_rows() {
  return rows_of_space();
}
const SceneRowList& model_rows() {
  return rows_of_model();
}

Scene load_scene(const fs::path& file, std::span<const std::string> overrides, const Scene* like,
                 const SceneUse& use) {
  return make_scene(SceneDocument::read(file, overrides), file, like, use);
}

Scene load_scene_with_sites(const fs::path& file, std::span<const std::string> overrides, const SceneUse& use,
                            const Scene* like) {
  return make_scene(SceneDocument::read(file, overrides), file, like, use, true);
}

Scene scene_of_text(std::string_view text, const std::string& name, std::span<const std::string> overrides,
                    const SceneUse& use) {
  return make_scene(SceneDocument::parse(text, name, overrides), name, nullptr, use);
}

Scene built_in_scene(std::span<const std::string> overrides) {
  return scene_of_text(built_in, "liver phantom", overrides);
}

std::set<std::string> scene_keys_read(std::string_view text, std::span<const std::string> overrides) {
  const SceneDocument document = SceneDocument::parse(text, "scene", overrides);
  make_scene(document, "scene", nullptr, {.spacing = false}, true);
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
