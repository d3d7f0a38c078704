#include "apps/study/study_file.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "apps/console/suggest.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/scene/toml_text.hpp"
#include "apps/study/study_inputs.hpp"
#include "apps/study/study_keys.hpp"
#include "apps/study/study_toml.hpp"
#include "apps/study/study_traces.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;
using study_keys::ClaimedKeys, study_keys::identity, study_keys::rebased, study_keys::scene_key;
using study_toml::in_file_order, study_toml::shown, study_toml::toml_of;

constexpr std::size_t most_study_cells = 100'000;

class Reader {
 public:
  Reader(fs::path file, std::span<const std::string> set);
  StudyFile read();
  struct Key;
  static std::span<const Key> keys();

 private:
  InputPlace where(const toml::node* node, const std::string& key) const;
  void check_root() const;
  void read_scene();
  void add_scenes();
  void read_seeds();
  void read_traces();
  void read_set();
  void read_fixed();
  void read_fixed_table(const toml::table& table, const std::string& path);
  void read_steps();
  void read_vary();
  StudyFileAxis read_axis(const std::string& column, const toml::node& node);
  StudyFileValue read_value(const std::string& column, const toml::node& node, const InputPlace& place);
  StudyFileValue read_together(const std::string& section, const toml::node& node, const InputPlace& place);
  void read_baseline();
  void read_sustained();
  void check_combinations() const;
  study_keys::StudyPaths paths() const { return {study_.file, study_.scene}; }

  StudyFile study_;
  toml::table root_;
  ClaimedKeys keys_;
  std::vector<std::string> set_;
  std::vector<std::string> together_;  // keys of the axis being read, where it is a section
  StudyFileAxis scenes_;               // one, or a list
  TraceHalf traces_ = TraceHalf::all;
  bool trace_patterns_ = false;  // some device is one
};

Reader::Reader(fs::path file, std::span<const std::string> set) : set_(set.begin(), set.end()) {
  study_.file = std::move(file);
  study_.text = read_toml(study_.file, "a study");
  root_ = parse_toml(study_.text, study_.file);
}

InputPlace Reader::where(const toml::node* node, const std::string& key) const {
  if (node && node->source().begin)
    return {.file = study_.file.string(), .line = node->source().begin.line, .key = key};
  return {.file = study_.file.string(), .key = key};
}

// The keys of a study and how each is read, in the order of reading.
struct Reader::Key {
  const char *name, *standard, *meaning;
  void (Reader::*read)();
};

std::span<const Reader::Key> Reader::keys() {
  static const Key all[] = {
      {"scene", "required", "file of the scene, relative to the study, or a list of scenes in one folder",
       &Reader::read_scene},
      {"seeds", "required", "list of whole numbers: every combination is run with each", &Reader::read_seeds},
      {"traces", "all",
       "of the files of a pattern in device: tuning (the 1st, 3rd, 5th … by name), table (the others) or all",
       &Reader::read_traces},
      {"step", "", "[[step]] tables: changes that add up", &Reader::read_steps},
      {"vary", "", "table of lists: every combination is run", &Reader::read_vary},
      {nullptr, nullptr, nullptr, &Reader::add_scenes},
      {nullptr, nullptr, nullptr, &Reader::read_fixed},
      {"sustained", "", "table: search the highest speed that each cell sustains", &Reader::read_sustained},
      {nullptr, nullptr, nullptr, &Reader::read_set},
      {"baseline", "the best", "value of the first varied key that the others are compared with",
       &Reader::read_baseline}};
  return all;
}

void Reader::check_root() const {
  std::vector<std::string> known;
  for (const Key& key : keys())
    if (key.name) known.emplace_back(key.name);
  const std::vector<std::string> sections = scene_sections();
  known.insert(known.end(), sections.begin(), sections.end());
  for (const auto& [key, node] : root_) {
    const std::string name(key.str());
    if (std::ranges::find(known, name) == known.end())
      throw InputError(where(&node, name), "unknown key" + expected_instead(name, known));
  }
}

void Reader::read_scene() {
  const toml::node* node = root_.get("scene");
  scenes_ = {.column = "scene", .where = where(node, "scene"), .values = {}};
  for (const fs::path& scene : study_scenes(node, study_.file))
    scenes_.values.push_back({.text = scene.stem().string(), .overrides = {}, .number = {}, .scene = scene});
  study_.scene = scenes_.values.front().scene;
  study_.scene_place = scenes_.where;
}

void Reader::add_scenes() {
  if (scenes_.values.size() > 1) study_.axes.push_back(scenes_);
}

void Reader::read_seeds() {
  const toml::node* node = root_.get("seeds");
  study_.seeds = study_seeds(node, study_.file);
  keys_.claim("session.seed", where(node, "seeds"), "given by the seeds of the study");
}

void Reader::read_traces() {
  traces_ = study_traces(root_.get("traces"), where(root_.get("traces"), "traces"));
}

// ---- what is fixed, stepped, varied

void Reader::read_set() {
  for (const std::string& text : set_) {
    const std::string key = text.substr(0, text.find('='));
    const std::string canonical = key == "model.select" ? "session.select" : key;
    if (keys_.unfix(canonical))  // --set may override a fixed key of the study
      std::erase_if(study_.fixed,
                    [&](const std::string& other) { return other.starts_with(canonical + "="); });
    const InputPlace place{.option = "--set", .key = key};
    keys_.claim(canonical, place, "fixed");
    if (key == "session.clock" && text.find("virtual") == std::string::npos)
      throw InputError(place, "expected 'virtual': the cells of a study must repeat");
    study_.fixed.push_back(text);
  }
}

void Reader::read_fixed_table(const toml::table& table, const std::string& path) {
  for (const auto& [name, node] : in_file_order(table)) {
    const std::string key = path + "." + name;
    const InputPlace place = where(node, key);
    if (node->is_table() && !(key == "clamp.below")) {
      read_fixed_table(*node->as_table(), key);
      continue;
    }
    const std::string canonical = key == "model.select" ? "session.select" : key;
    keys_.claim(canonical, place, "fixed");
    if (key == "session.clock" && shown(*node) != "virtual")
      throw InputError(
          place, fmt::format("is '{}', expected 'virtual': the cells of a study must repeat", shown(*node)));
    study_.fixed.push_back(canonical + "=" + rebased(paths(), key, *node));
  }
}

void Reader::read_fixed() {
  for (const std::string& section : scene_sections()) {
    const toml::node* node = root_.get(section);
    if (!node) continue;
    if (!node->is_table()) throw InputError(where(node, section), "expected a table");
    read_fixed_table(*node->as_table(), section);
  }
}

// Keys of one section that change together: { name = "r3, n = 100", kernel = "cubic", neighbours = 100 }. A key of
// another section is written in full, in quotes.
StudyFileValue Reader::read_together(const std::string& section, const toml::node& node,
                                     const InputPlace& place) {
  const toml::table* table = node.as_table();
  if (!table || table->empty())
    throw InputError(place, fmt::format("holds {}, expected tables of keys of [{}]", toml_of(node), section));
  const toml::node* name = table->get("name");
  StudyFileValue value{.text = name ? shown(*name) : shown(node), .overrides = {}, .number = {}};
  for (const auto& [word, child] : in_file_order(*table)) {
    if (word == "name") continue;
    const bool whole = word.find('.') != std::string::npos;
    const std::string key = scene_key(whole ? word : fmt::format("{}.{}", section, word), place, false);
    value.overrides.push_back(fmt::format("{}={}", key, rebased(paths(), key, *child)));
    if (std::ranges::find(together_, key) == together_.end()) together_.push_back(key);
  }
  return value;
}

StudyFileValue Reader::read_value(const std::string& column, const toml::node& node,
                                  const InputPlace& place) {
  const std::string key = scene_key(column, place, true);
  if (is_scene_section(key)) return read_together(key, node, place);
  StudyFileValue value{.text = shown(node), .overrides = {}, .number = {}};
  if (key == "target_load" || key == "speed") {
    value.number = node.value<double>();
    if (node.is_boolean() || !value.number || !std::isfinite(*value.number) || *value.number <= 0)
      throw InputError(place, fmt::format("holds {}, expected numbers above 0", toml_of(node)));
  } else {
    value.overrides.push_back(key + "=" + rebased(paths(), key, node));
  }
  return value;
}

StudyFileAxis Reader::read_axis(const std::string& column, const toml::node& node) {
  StudyFileAxis axis{.column = column, .where = where(&node, "vary." + column), .values = {}};
  const std::string key = scene_key(column, axis.where, true);
  const toml::array* list = node.as_array();
  if (!list) throw InputError(axis.where, fmt::format("is {}, expected a list of values", toml_of(node)));
  if (list->empty()) throw InputError(axis.where, "is an empty list, expected at least one value");
  std::map<std::string, std::string> seen;  // identity -> as written
  const auto add = [&](const toml::node& element, const InputPlace& place) {
    StudyFileValue value = read_value(column, element, place);
    const auto [other, fresh] =
        seen.try_emplace(element.is_table() ? value.text : identity(paths(), key, element), value.text);
    if (!fresh)
      throw InputError(place,
                       other->second == value.text
                           ? fmt::format("holds '{}' twice, expected each value once", value.text)
                           : fmt::format("holds '{}', which is the same as '{}', expected each value once",
                                         value.text, other->second));
    axis.values.push_back(std::move(value));
  };
  for (const toml::node& element : *list) {
    const InputPlace place = where(&element, "vary." + column);
    if (key != "session.device" || !is_trace_pattern(element)) {
      add(element, place);
      continue;
    }
    trace_patterns_ = true;
    for (const auto& [name, device] :
         matching_traces(shown(element), traces_, study_.file, study_.scene, place)) {
      if (std::ranges::find(axis.values, name, &StudyFileValue::text) != axis.values.end())
        throw InputError(place, fmt::format("holds two files '{}', expected names that differ", name));
      add(toml::value<std::string>(device), place);
      axis.values.back().text = name;
    }
  }
  if (together_.empty()) keys_.claim(key, axis.where, "varied");
  for (const std::string& one : std::exchange(together_, {})) keys_.claim(one, axis.where, "varied");
  return axis;
}

void Reader::read_vary() {
  const toml::node* node = root_.get("vary");
  if (!node) return;
  if (!node->is_table()) throw InputError(where(node, "vary"), "expected a table of lists");
  if (node->as_table()->empty())
    throw InputError(where(node, "vary"), "is empty, expected at least one key with a list");
  // An unquoted dotted key (model.kernel = […]) arrives as a table in a table.
  const auto visit = [&](const auto& self, const toml::table& table, const std::string& path) -> void {
    for (const auto& [name, child] : in_file_order(table)) {
      const std::string column = path.empty() ? name : path + "." + name;
      if (child->is_table())
        self(self, *child->as_table(), column);
      else
        study_.axes.push_back(read_axis(column, *child));
    }
  };
  visit(visit, *node->as_table(), "");
}

void Reader::read_steps() {
  const toml::node* node = root_.get("step");
  if (!node) return;
  const toml::array* list = node->as_array();
  if (!list || list->empty() || !list->is_homogeneous<toml::table>())
    throw InputError(where(node, "step"),
                     "expected [[step]] tables, each with a name and the keys it changes");
  StudyFileAxis axis{.column = "step", .where = where(node, "step"), .values = {}};
  std::map<std::string, std::string> kept;  // what holds so far
  std::map<std::string, InputPlace> places;
  for (const toml::node& element : *list) {
    const toml::table& table = *element.as_table();
    const toml::node* name = table.get("name");
    if (!name || !name->is_string() || name->as_string()->get().empty())
      throw InputError(where(&element, "step.name"), "missing, expected a name for the step");
    const std::string label = name->as_string()->get();
    for (const StudyFileValue& other : axis.values)
      if (other.text == label)
        throw InputError(where(name, "step.name"),
                         fmt::format("'{}' is used twice, expected each once", label));
    for (const auto& [written, value] : in_file_order(table)) {
      if (written == "name") continue;
      const InputPlace place = where(value, "step." + written);
      const std::string key = scene_key(written, place, false);
      std::erase_if(kept, [&](const auto& before) { return exclude_each_other(key, before.first); });
      kept[key] = rebased(paths(), key, *value);
      places.try_emplace(key, place);
    }
    StudyFileValue step{.text = label, .overrides = {}, .number = {}};
    for (const auto& [key, value] : kept) step.overrides.push_back(key + "=" + value);
    axis.values.push_back(std::move(step));
  }
  for (const auto& [key, place] : places) keys_.claim(key, place, "changed by a step");
  study_.axes.push_back(std::move(axis));
}

void Reader::read_baseline() {
  const toml::node* node = root_.get("baseline");
  if (!node) return;
  if (study_.axes.empty()) throw InputError(where(node, "baseline"), "nothing varies, expected no baseline");
  std::vector<std::string> values;
  for (const StudyFileValue& value : study_.axes.front().values) values.push_back(value.text);
  const auto found = std::ranges::find(values, shown(*node));
  if (found == values.end())
    throw InputError(where(node, "baseline"), fmt::format("is '{}', expected a value of {}: {}", shown(*node),
                                                          study_.axes.front().column, listed(values)));
  study_.baseline = static_cast<std::size_t>(found - values.begin());
}

void Reader::read_sustained() {
  const toml::node* node = root_.get("sustained");
  if (!node) return;
  if (!node->is_table()) throw InputError(where(node, "sustained"), "expected a table");
  const SustainedOptions options = study_sustained(*node->as_table(), study_.file);
  keys_.claim("speed", where(node, "sustained"), "searched");
  keys_.claim("session.seconds", where(node, "sustained"), "given by travel over speed");
  if (const InputPlace* load = keys_.place_of("target_load"))
    throw InputError(
        where(node, "sustained"),
        fmt::format(
            "searches the speed at which a given number of workers keeps up, but target_load sets what "
            "they keep up with ({}); expected one or the other",
            load->text()));
  study_.sustained = options;
  study_.sustained_place = where(node, "sustained");
}

void Reader::check_combinations() const {
  if (const toml::node* node = root_.get("traces"); node && !trace_patterns_)
    throw InputError(where(node, "traces"),
                     "has no effect, expected a pattern of files in vary.device, as \"trace:traces/*.csv\"");
  double total = static_cast<double>(study_.seeds.size());
  for (const StudyFileAxis& axis : study_.axes) total *= static_cast<double>(axis.values.size());
  if (total > static_cast<double>(most_study_cells))
    throw InputError(study_.axes.empty() ? where(root_.get("seeds"), "seeds") : study_.axes.back().where,
                     fmt::format("makes {:.4g} cells, expected at most {}", total, most_study_cells));
}

StudyFile Reader::read() {
  check_root();
  for (const Key& key : keys()) (this->*key.read)();
  check_combinations();
  study_.origin = keys_.places();
  return std::move(study_);
}

}  // namespace

Study StudyFile::study() const {
  Study typed{.seeds = seeds, .axes = {}, .baseline = baseline, .sustained = sustained};
  for (const StudyFileAxis& axis : axes) {
    typed.axes.push_back({.column = axis.column, .values = {}});
    for (const StudyFileValue& value : axis.values)
      typed.axes.back().values.push_back({.text = value.text, .number = value.number});
  }
  return typed;
}

std::vector<std::string> StudyFile::overrides(std::span<const std::size_t> chosen) const {
  std::vector<std::string> all = fixed;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::vector<std::string>& some = axes[i].values[chosen[i]].overrides;
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

const fs::path& StudyFile::scene_of(std::span<const std::size_t> chosen) const {
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (const fs::path& own = axes[i].values[chosen[i]].scene; !own.empty()) return own;
  return scene;
}

std::vector<DeclaredTable> study_tables() {
  DeclaredTable file{"study", "The file itself.", {}}, sustained = study_keys::declared_sustained();
  for (const Reader::Key& key : Reader::keys())
    if (key.name) file.rows.push_back({key.name, "", key.standard, key.meaning});
  file.rows.push_back({fmt::format("{}", fmt::join(scene_sections(), ", ")), "", "as in the scene",
                       "tables as in a scene: keys that are the same in all cells"});
  return {file, study_keys::declared_vary(), study_keys::declared_step(), sustained};
}

StudyFile read_study(const fs::path& file, std::span<const std::string> set) {
  return Reader(file, set).read();
}

}  // namespace forefeel
