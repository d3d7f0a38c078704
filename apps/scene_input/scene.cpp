#include "apps/scene_input/scene.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "apps/console/suggest.hpp"
#include "apps/scene_input/option_names.hpp"
#include "apps/scene_input/scene_body.hpp"
#include "apps/scene_input/sha256.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

// ---- text and overrides
// -------------------------------------------------------------------------------------------

std::string read_text(const fs::path& file) {
  if (!fs::exists(file)) throw InputError({.file = file.string()}, "no such file, expected a scene (TOML)");
  std::ifstream in(file, std::ios::binary);
  if (!fs::is_regular_file(file) || !in)
    throw InputError({.file = file.string()}, "cannot be read, expected a scene (TOML)");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

toml::table parse_scene(const fs::path& file) {
  try {
    return toml::parse(read_text(file), file.string());
  } catch (const toml::parse_error& error) {
    std::string problem(error.description());
    std::ranges::replace(problem, '\n', ' ');
    throw InputError({.file = file.string(), .line = error.source().begin.line}, "not TOML: " + problem);
  }
}

// The text after '=' as TOML where it is one value, as a bare string otherwise.
toml::table parse_value(const std::string& text) {
  if (text.find('\n') == std::string::npos) {
    try {
      toml::table table = toml::parse("value = " + text, std::string_view("--set"));
      if (table.size() == 1) return table;
    } catch (const toml::parse_error&) {  // a bare word
    }
  }
  return toml::table{{"value", text}};
}

// Of these only one may be given; an override of one takes the place of the others.
const std::vector<std::pair<std::string, std::vector<std::string>>> alternatives{
    {"body", {"mesh", "phantom"}},
    {"clamp", {"nodes", "group", "below"}},
    {"contact", {"node", "nodes", "nearest", "group"}}};

void drop_alternatives(const std::string& section, const std::string& key, toml::table& table) {
  for (const auto& [name, keys] : alternatives)
    if (name == section && std::ranges::find(keys, key) != keys.end())
      for (const std::string& other : keys)
        if (other != key) table.erase(other);
}

void override_key(toml::table& scene, const std::string& text, std::set<std::string>& overridden) {
  const std::size_t equals = text.find('=');
  const InputPlace where =
      equals == std::string::npos
          ? InputPlace{.option = "--set", .key = text}
          : InputPlace{.option = "--set", .key = text.substr(0, equals), .value = text.substr(equals + 1)};
  if (equals == std::string::npos || equals == 0)
    throw InputError(where, "has no value, expected key.path=value");
  const std::string path = text.substr(0, equals);
  std::vector<std::string> keys;
  std::istringstream parts(path);
  for (std::string key; std::getline(parts, key, '.');) keys.push_back(key);
  if (std::ranges::find(keys, "") != keys.end() || path.ends_with("."))
    throw InputError(where, "has an empty key, expected key.path=value");
  toml::table* table = &scene;
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    if (i == 1) drop_alternatives(keys[0], keys[1], *table);
    table = table->emplace<toml::table>(keys[i]).first->second.as_table();
    if (!table) throw InputError(where, fmt::format("'{}' is not a table of the scene", keys[i]));
  }
  if (keys.size() == 2) drop_alternatives(keys[0], keys[1], *table);
  toml::table parsed = parse_value(text.substr(equals + 1));
  table->insert_or_assign(keys.back(), std::move(*parsed.get("value")));
  overridden.insert(path);
}

// ---- sections
// -----------------------------------------------------------------------------------------------------

constexpr double most_positions =
    2e7;  // of a lattice: beyond it a slip of the spacing is likelier than an intent

void choose_spacing_of(const SceneTable& table, Scene& scene) {
  if ((scene.space.box.size().array() <= 0).any())
    throw InputError(table.where("spacing"),
                     "is \"auto\" with a flat box, expected a box with a volume, or a number [m]");
  scene.chosen_spacing = automatic_spacing(scene.body, scene.identity,
                                           {.box = scene.space.box,
                                            .tolerance = scene.tolerance,
                                            .model = scene.model,
                                            .coverage = scene.space.coverage,
                                            .floor = scene.session.judging.error_floor},
                                           cache_folder());
  scene.space.spacing = scene.chosen_spacing->spacing;
  if (!scene.chosen_spacing->holds)
    scene.warnings.push_back(fmt::format(
        "{}: no spacing that was tried makes safe mean an error below {:g} % in {:g} % of it; the finest is "
        "taken",
        table.where("spacing").text(), 100 * scene.tolerance,
        100 - 100 * scene.chosen_spacing->allowed_share));
}

void read_state_space(const SceneTable& table, const TetMesh& mesh, bool defaults, Scene& scene) {
  const bool automatic = table.is_text("spacing", "auto");
  if (!defaults)
    for (const std::string key : {"spacing", "box"})
      if (!table.has(key))
        throw table.wrong(key, key == "box" ? "[[x0, y0, z0], [x1, y1, z1]]" : "a number above 0 [m]");
  scene.tolerance = table.number("tolerance", positive()).value_or(scene.tolerance);
  if (automatic)
    scene.space.spacing = longest_side(mesh) / 36;  // for a box that is not given
  else
    scene.space.spacing =
        table.number("spacing", {0, 1e300, true, false, "a number above 0 [m], or \"auto\""}).value_or(0.006);
  scene.space.box = table.has("box") ? *table.box("box") : default_box(mesh, scene.space.spacing);
  if (automatic) choose_spacing_of(table, scene);
  const double positions = ((scene.space.box.size() / scene.space.spacing).array().floor() + 1).prod();
  if (positions > most_positions)
    throw InputError(
        table.where("spacing"),
        fmt::format("gives {:.3g} positions in the box, expected at most {:g}", positions, most_positions));
  scene.displacements = table.boolean("displacements").value_or(false);
}

ModelOptions read_model(const SceneTable& table) {
  ModelOptions model;
  model.kernel =
      table
          .word<Kernel>("kernel",
                        {{"linear", Kernel::linear}, {"cubic", Kernel::cubic}, {"quintic", Kernel::quintic}})
          .value_or(Kernel::quintic);
  model.data =
      table.word<Data>("data", {{"force", Data::force}, {"force+stiffness", Data::force_and_stiffness}})
          .value_or(model.kernel == Kernel::linear ? Data::force : Data::force_and_stiffness);
  if (model.kernel == Kernel::linear && model.data == Data::force_and_stiffness)
    throw table.wrong("data", "\"force\" with the linear kernel, which has no derivative at a state");
  model.neighbours = static_cast<std::size_t>(
      table.integer("neighbours", 1, 100'000).value_or(model.data == Data::force ? 100 : 25));
  model.select = table.word("select", select_words()).value_or(model.select);
  model.ridge = table.number("ridge", not_negative()).value_or(model.ridge);
  return model;
}

void read_switch(const SceneTable& session, SwitchOptions& options) {
  options.rule = session.word("switch", switch_words()).value_or(options.rule);
  const SceneTable jnd = session.sub("jnd", {"share", "floor"});
  options.jnd_share = jnd.number("share", share()).value_or(options.jnd_share);
  options.jnd_floor = jnd.number("floor", positive()).value_or(options.jnd_floor);
}

void read_limits(const SceneTable& limits, SessionOptions& session) {
  session.safety.force_limit = limits.number("force", positive()).value_or(session.safety.force_limit);
  session.safety.slew_limit = limits.number("slew", positive()).value_or(session.safety.slew_limit);
  session.safety.ramp_seconds = limits.number("ramp", not_negative()).value_or(session.safety.ramp_seconds);
  session.safety.stale_seconds = limits.number("stale", positive()).value_or(session.safety.stale_seconds);
}

std::optional<fs::path> file_beside(const SceneTable& table, const std::string& key, const fs::path& folder) {
  const std::optional<std::string> text = table.text(key);
  if (!text) return {};
  const fs::path path = folder / *text;
  if (!fs::exists(path)) throw InputError(table.where(key), fmt::format("no such file '{}'", path.string()));
  return path;
}

void read_session(const SceneTable& table, const fs::path& folder, SessionOptions& session) {
  session.clock.kind = table.word("clock", clock_words()).value_or(session.clock.kind);
  session.clock.seconds = table.number("seconds", positive()).value_or(session.clock.seconds);
  session.motion.device = table.text("device").value_or(session.motion.device);
  session.planning.policy = table.text("policy").value_or(session.planning.policy);
  const std::vector<std::string> policies = policy_names();
  if (std::ranges::find(policies, session.planning.policy) == policies.end())
    throw table.wrong("policy", fmt::format("one of {} (nearest: '{}')", listed(policies),
                                            nearest_word(session.planning.policy, policies)));
  session.motion.predictor =
      table.word<std::string>("predictor", {{"kalman", "kalman"}, {"constant-velocity", "constant-velocity"}})
          .value_or(session.motion.predictor);
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
  session.workers.cost = table.text("cost").value_or(session.workers.cost);
  session.workers.latency = table.number("latency", not_negative()).value_or(session.workers.latency);
  session.planning.arrivals = file_beside(table, "arrivals", folder);
  session.planning.batch = static_cast<int>(table.integer("batch", 0, 8).value_or(session.planning.batch));
  session.workers.batch_share = table.number("batch_share", positive()).value_or(session.workers.batch_share);
  session.planning.rest_first = table.boolean("rest_first").value_or(session.planning.rest_first);
  session.model.first_guess = table.boolean("first_guess").value_or(session.model.first_guess);
  session.planning.rest_known = table.boolean("rest_known").value_or(session.planning.rest_known);
  session.planning.preempt = table.boolean("preempt").value_or(session.planning.preempt);
  session.seed = static_cast<std::uint64_t>(table.integer("seed", 0, INT64_MAX).value_or(0));
  session.judging.error_floor = table.number("error_floor", positive()).value_or(session.judging.error_floor);
  session.judging.reference_step =
      table.number("reference_step", positive()).value_or(session.judging.reference_step);
  session.judging.visit_cell =
      table.number("visit_cell", not_negative()).value_or(session.judging.visit_cell);
  session.judging.visit_stride =
      static_cast<int>(table.integer("visit_stride", 1, 1000000).value_or(session.judging.visit_stride));
  read_limits(table.sub("limits", {"force", "slew", "ramp", "stale"}), session);
}

std::string hash_of(const toml::table& scene, const BodyIdentity& identity) {
  std::ostringstream text;
  text << toml::toml_formatter(scene);
  Sha256 hash;
  hash.add(text.str());
  for (const auto& [key, value] : identity) hash.add(key + "=" + value + "\n");
  return hash.hex();
}

std::string body_source(const toml::table& scene, const fs::path& file) {
  std::ostringstream text;
  text << file.string() << '\n';
  for (const char* section : {"body", "material", "clamp", "contact"})
    if (const toml::table* table = scene[section].as_table())
      text << section << '\n' << toml::toml_formatter(*table) << '\n';
  return text.str();
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
  scene.warnings.insert(scene.warnings.end(), like.warnings.begin(), like.warnings.end());
}

bool writable_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  return fs::is_directory(folder, error) && access(folder.c_str(), W_OK) == 0;
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

Scene make_scene(toml::table table, const fs::path& file, std::span<const std::string> overrides,
                 const Scene* like) {
  std::set<std::string> overridden;
  for (const std::string& text : overrides) override_key(table, text, overridden);

  const SceneTable root(&table, "", file.string(), overridden,
                        {"body", "material", "clamp", "contact", "state_space", "model", "session"});
  const SceneTable space = root.sub("state_space", {"spacing", "box", "displacements", "tolerance"});
  const SceneTable model = root.sub("model", {"kernel", "data", "neighbours", "select", "ridge"});
  const SceneTable session = root.sub(
      "session",
      {"device",      "clock",    "seconds",     "workers",        "policy",       "predictor",     "switch",
       "select",      "method",   "placement",   "visit_cell",     "visit_stride", "update_travel", "cost",
       "latency",     "arrivals", "preempt",     "rest_first",     "first_guess",  "rest_known",    "batch",
       "batch_share", "seed",     "error_floor", "reference_step", "jnd",          "limits"});
  const BodySections sections{root.sub("body", {"mesh", "phantom", "elements", "length", "element"}),
                              root.sub("material", {"law", "young", "poisson"}),
                              root.sub("clamp", {"nodes", "group", "below"}),
                              root.sub("contact", {"node", "nodes", "nearest", "group", "radius"})};
  Scene scene;
  scene.file = file;
  scene.model = read_model(model);
  if (model.has("select") && session.has("select"))
    throw session.wrong("select", "only one of model.select and session.select");
  scene.model.select = session.word("select", select_words()).value_or(scene.model.select);
  read_session(session, file.parent_path(), scene.session);
  scene.device_place = session.where("device");
  scene.cost_place = session.where("cost");
  scene.box_place = space.where("box");
  if (session.has("arrivals")) scene.arrivals_place = session.where("arrivals");
  for (const std::string& key : scheduling_keys())
    if (session.has(key)) scene.scheduling.emplace_back("session." + key, session.where(key));
  scene.body_source = body_source(table, file);
  if (like && like->body_source == scene.body_source)
    share_body(*like, scene);
  else
    take_body(read_body(sections, file.parent_path(), file.string(), scene.warnings), scene);
  read_state_space(space, scene.body->mesh, sections.body.has("phantom"), scene);
  scene.model.length = scene.space.spacing;
  scene.session.model.fit = scene.model;
  scene.hash = hash_of(table, scene.identity);
  return scene;
}

}  // namespace

Scene load_scene(const fs::path& file, std::span<const std::string> overrides, const Scene* like) {
  return make_scene(parse_scene(file), file, overrides, like);
}

Scene built_in_scene(std::span<const std::string> overrides) {
  return make_scene(toml::parse(built_in), "liver phantom", overrides, nullptr);
}

const std::vector<std::string>& scheduling_keys() {
  static const std::vector<std::string> keys{"policy",      "workers",   "cost",       "latency",
                                             "preempt",     "placement", "predictor",  "rest_first",
                                             "first_guess", "batch",     "batch_share"};
  return keys;
}

bool exclude_each_other(const std::string& key, const std::string& other) {
  const auto among = [](const std::string& name, const std::string& section,
                        const std::vector<std::string>& keys) {
    return name.starts_with(section + ".") &&
           std::ranges::find(keys, name.substr(section.size() + 1)) != keys.end();
  };
  return key != other && std::ranges::any_of(alternatives, [&](const auto& of) {
           return among(key, of.first, of.second) && among(other, of.first, of.second);
         });
}

std::string no_effect_beside(const std::string& arrivals) {
  return fmt::format(
      "has no effect where states arrive at given times ({}), since nothing is solved; expected one or the "
      "other",
      arrivals);
}

std::string_view built_in_scene_text() {
  return built_in;
}

fs::path cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (cache && fs::path(cache).is_absolute() && writable_folder(fs::path(cache) / "forefeel"))
    return fs::path(cache) / "forefeel";
  if (home && *home && writable_folder(fs::path(home) / ".cache" / "forefeel"))
    return fs::path(home) / ".cache" / "forefeel";
  return {};
}

}  // namespace forefeel
