#include "apps/study/study_file.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include "apps/console/suggest.hpp"
#include "apps/scene_input/scene.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_cells = 100'000;
const std::vector<std::string> short_keys{"policy", "select", "workers", "device", "cost", "switch"};
const std::vector<std::string> vary_words{"policy", "select", "workers",     "device",
                                          "cost",   "switch", "target_load", "speed"};
const std::vector<std::string> scene_sections{"body",        "material", "clamp",  "contact",
                                              "state_space", "model",    "session"};

// ---- text

std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || !fs::is_regular_file(file))
    throw InputError({.file = file.string()}, "cannot be read, expected a study (TOML)");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

toml::table parse(const std::string& text, const fs::path& file) {
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    std::string problem(error.description());
    std::ranges::replace(problem, '\n', ' ');
    throw InputError({.file = file.string(), .line = error.source().begin.line}, "not TOML: " + problem);
  }
}

std::string toml_of(const toml::node& node) {
  std::ostringstream out;
  const auto flags = toml::toml_formatter::default_flags & ~toml::format_flags::allow_literal_strings &
                     ~toml::format_flags::allow_multi_line_strings &
                     ~toml::format_flags::allow_binary_integers & ~toml::format_flags::allow_octal_integers &
                     ~toml::format_flags::allow_hexadecimal_integers;
  node.visit([&](const auto& value) { out << toml::toml_formatter(value, flags); });
  std::string text = out.str();
  std::ranges::replace(text, '\n', ' ');
  return text;
}

// Numbers in as few digits as read back to the same.
std::string brief(const toml::node& node) {
  if (const auto* number = node.as_floating_point(); number && std::isfinite(number->get())) {
    const std::string text = fmt::format("{}", number->get());
    return text.find_first_not_of("-0123456789") == std::string::npos ? text + ".0" : text;
  }
  const auto* list = node.as_array();
  if (!list || list->empty()) return toml_of(node);
  std::string text;
  for (const toml::node& element : *list) text += (text.empty() ? "[ " : ", ") + brief(element);
  return text + " ]";
}

std::string shown(const toml::node& node) {
  const auto* text = node.as_string();
  return text ? text->get() : brief(node);
}

// toml++ sorts keys; here what a person wrote first comes first.
std::vector<std::pair<std::string, const toml::node*>> in_file_order(const toml::table& table) {
  std::vector<std::pair<std::string, const toml::node*>> entries;
  for (const auto& [key, value] : table) entries.emplace_back(std::string(key.str()), &value);
  std::ranges::stable_sort(entries, [](const auto& a, const auto& b) {
    const auto begin_a = a.second->source().begin, begin_b = b.second->source().begin;
    return std::pair(begin_a.line, begin_a.column) < std::pair(begin_b.line, begin_b.column);
  });
  return entries;
}

class Reader {
 public:
  Reader(fs::path file, std::span<const std::string> set);
  StudyFile read();

 private:
  InputPlace where(const toml::node* node, const std::string& key) const;
  void check_root() const;
  void read_scene();
  void read_seeds();
  void read_set(std::span<const std::string> set);
  void read_fixed();
  void read_fixed_table(const toml::table& table, const std::string& path);
  void read_steps();
  void read_vary();
  StudyFileAxis read_axis(const std::string& column, const toml::node& node);
  StudyFileValue read_value(const std::string& column, const toml::node& node, const InputPlace& place);
  StudyFileValue read_together(const std::string& section, const toml::node& node, const InputPlace& place);
  void read_baseline();
  void read_sustained();

  std::string scene_key(const std::string& written, const InputPlace& place, bool pseudo_allowed) const;
  void claim(const std::string& key, const InputPlace& place, const std::string& how);
  std::string rebased(const std::string& key, const toml::node& node) const;
  std::string identity(const std::string& key, const toml::node& node) const;
  void check_combinations() const;

  StudyFile study_;
  toml::table root_;
  std::map<std::string, std::pair<std::string, InputPlace>> claimed_;  // key -> how, where
  std::vector<std::string> set_;
  std::vector<std::string> together_;  // keys of the axis being read, where it is a section
};

Reader::Reader(fs::path file, std::span<const std::string> set) : set_(set.begin(), set.end()) {
  study_.file = std::move(file);
  study_.text = read_text(study_.file);
  root_ = parse(study_.text, study_.file);
}

InputPlace Reader::where(const toml::node* node, const std::string& key) const {
  if (node && node->source().begin)
    return {.file = study_.file.string(), .line = node->source().begin.line, .key = key};
  return {.file = study_.file.string(), .key = key};
}

void Reader::check_root() const {
  std::vector<std::string> known{"scene", "seeds", "baseline", "vary", "step", "sustained"};
  known.insert(known.end(), scene_sections.begin(), scene_sections.end());
  for (const auto& [key, node] : root_) {
    const std::string name(key.str());
    if (std::ranges::find(known, name) == known.end())
      throw InputError(where(&node, name), fmt::format("unknown key, did you mean '{}'? Expected one of {}",
                                                       nearest_word(name, known), listed(known)));
  }
}

void Reader::read_scene() {
  const toml::node* node = root_.get("scene");
  if (!node || !node->is_string())
    throw InputError(where(node, "scene"), "missing, expected the file of a scene");
  study_.scene = study_.file.parent_path() / node->as_string()->get();
  study_.scene_place = where(node, "scene");
  if (!fs::is_regular_file(study_.scene))
    throw InputError(
        where(node, "scene"),
        fmt::format("no such file '{}', expected a scene, relative to the study", study_.scene.string()));
}

void Reader::read_seeds() {
  const toml::node* node = root_.get("seeds");
  const toml::array* list = node ? node->as_array() : nullptr;
  if (node && !list)
    throw InputError(where(node, "seeds"),
                     fmt::format("is {}, expected a list of whole numbers, as [1, 2]", toml_of(*node)));
  if (!list) throw InputError(where(node, "seeds"), "missing, expected a list of whole numbers");
  if (list->empty()) throw InputError(where(node, "seeds"), "is empty, expected at least one whole number");
  for (const toml::node& element : *list) {
    if (!element.is_integer() || element.as_integer()->get() < 0)
      throw InputError(where(&element, "seeds"),
                       fmt::format("holds {}, expected whole numbers of at least 0", toml_of(element)));
    const auto seed = static_cast<std::uint64_t>(element.as_integer()->get());
    if (std::ranges::find(study_.seeds, seed) != study_.seeds.end())
      throw InputError(where(&element, "seeds"),
                       fmt::format("holds {} twice, expected each seed once", seed));
    study_.seeds.push_back(seed);
  }
  claim("session.seed", where(node, "seeds"), "given by the seeds of the study");
}

// ---- keys: each given once, in one way

std::string Reader::scene_key(const std::string& written, const InputPlace& place,
                              bool pseudo_allowed) const {
  if (std::ranges::find(short_keys, written) != short_keys.end()) return "session." + written;
  if (pseudo_allowed && (written == "target_load" || written == "speed")) return written;
  if (written == "model.select") return "session.select";  // one and the same
  const std::string section = written.substr(0, written.find('.'));
  const bool dotted = section.size() + 1 < written.size();
  if (dotted && std::ranges::find(scene_sections, section) != scene_sections.end()) return written;
  if (dotted)
    throw InputError(place, fmt::format("unknown section, did you mean '{}{}'? Expected one of {}",
                                        nearest_word(section, scene_sections), written.substr(section.size()),
                                        listed(scene_sections)));
  if (pseudo_allowed && std::ranges::find(scene_sections, written) != scene_sections.end()) return written;
  const std::vector<std::string>& words = pseudo_allowed ? vary_words : short_keys;
  throw InputError(place,
                   fmt::format("unknown key, did you mean '{}'? Expected one of {}, or a scene key in quotes "
                               "(\"model.kernel\")",
                               nearest_word(written, words), listed(words)));
}

// A key and a table that holds it are the same place, and so are the load and the cost it stands for.
void Reader::claim(const std::string& key, const InputPlace& place, const std::string& how) {
  const auto within = [](const std::string& inner, const std::string& outer) {
    return inner == outer || inner.starts_with(outer + ".");
  };
  for (const auto& [other, given] : claimed_) {
    const bool cost_twice = (key == "target_load" && other == "session.cost") ||
                            (key == "session.cost" && other == "target_load");
    if (within(key, other) || within(other, key) || cost_twice)
      throw InputError(place, fmt::format("{}, but {} is {} ({}); expected it once", how, other, given.first,
                                          given.second.text()));
    // Those of one axis take turns.
    const bool in_turn = place == given.second || (how == "changed by a step" && how == given.first);
    if (exclude_each_other(key, other) && !in_turn && place.option.empty())
      throw InputError(place, fmt::format("{}, but {} is {} ({}); expected one of the two", how, other,
                                          given.first, given.second.text()));
  }
  if (key == "session.clock" && how != "fixed")
    throw InputError(place, "the clock of a study is virtual, so that its cells repeat; it cannot be varied");
  claimed_[key] = {how, place};
  study_.origin[key] = place;
}

// A file named in the study is looked for beside the study first; the scene wants it relative to itself.
std::string Reader::rebased(const std::string& key, const toml::node& node) const {
  const auto* text = node.as_string();
  const bool names_file = key == "session.device" || key == "session.arrivals" || key == "body.mesh";
  if (!text || !names_file) return toml_of(node);
  const auto moved = [&](const std::string& file) -> std::string {
    const fs::path beside = study_.file.parent_path() / file;
    if (file.empty() || fs::path(file).is_absolute() || !fs::exists(beside)) return file;
    const fs::path folder = fs::absolute(study_.scene).parent_path();
    return fs::proximate(fs::absolute(beside).lexically_normal(), folder.lexically_normal()).string();
  };
  std::string value = text->get();
  if (key != "session.device") {
    value = moved(value);
  } else if (value.starts_with("trace:")) {
    const std::size_t end = std::min(value.find(','), value.size());
    value = "trace:" + moved(value.substr(6, end - 6)) + value.substr(end);
  }
  return toml_of(toml::value<std::string>(value));
}

// The same for values that are the same however they are written: 2, 2.0 and 0x2; a file by any of its names.
std::string Reader::identity(const std::string& key, const toml::node& node) const {
  if (const auto* number = node.as_integer()) return std::to_string(number->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  const std::string written = rebased(key, node);
  const auto* text = node.as_string();
  const bool device = key == "session.device";
  if (!text ||
      !(device ? text->get().starts_with("trace:") : key == "session.arrivals" || key == "body.mesh"))
    return written;
  const std::string value = toml::parse("value = " + written)["value"].value_or(std::string());
  const std::size_t begin = device ? 6 : 0,
                    end = device ? std::min(value.find(','), value.size()) : value.size();
  std::error_code error;
  const fs::path file =
      fs::weakly_canonical(study_.scene.parent_path() / value.substr(begin, end - begin), error);
  return error ? written : value.substr(0, begin) + file.string() + value.substr(end);
}

// ---- what is fixed, stepped, varied

void Reader::read_set(std::span<const std::string> set) {
  for (const std::string& text : set) {
    const std::string key = text.substr(0, text.find('='));
    const std::string canonical = key == "model.select" ? "session.select" : key;
    if (const auto found = claimed_.find(canonical);
        found != claimed_.end() && found->second.first == "fixed") {
      claimed_.erase(found);  // what the study fixes, --set may fix otherwise
      std::erase_if(study_.fixed,
                    [&](const std::string& other) { return other.starts_with(canonical + "="); });
    }
    const InputPlace place{.option = "--set", .key = key};
    claim(canonical, place, "fixed");
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
    claim(canonical, place, "fixed");
    if (key == "session.clock" && shown(*node) != "virtual")
      throw InputError(
          place, fmt::format("is '{}', expected 'virtual': the cells of a study must repeat", shown(*node)));
    study_.fixed.push_back(canonical + "=" + rebased(key, *node));
  }
}

void Reader::read_fixed() {
  for (const std::string& section : scene_sections) {
    const toml::node* node = root_.get(section);
    if (!node) continue;
    if (!node->is_table()) throw InputError(where(node, section), "expected a table");
    read_fixed_table(*node->as_table(), section);
  }
}

// Keys of one section that change together: { name = "r3, n = 100", kernel = "cubic", neighbours = 100 }.
StudyFileValue Reader::read_together(const std::string& section, const toml::node& node,
                                     const InputPlace& place) {
  const toml::table* table = node.as_table();
  if (!table || table->empty())
    throw InputError(place, fmt::format("holds {}, expected tables of keys of [{}]", toml_of(node), section));
  const toml::node* name = table->get("name");
  StudyFileValue value{.text = name ? shown(*name) : shown(node), .overrides = {}, .number = {}};
  for (const auto& [word, child] : in_file_order(*table)) {
    const std::string key = scene_key(fmt::format("{}.{}", section, word), place, false);
    if (word == "name") continue;
    value.overrides.push_back(fmt::format("{}={}", key, rebased(key, *child)));
    if (std::ranges::find(together_, key) == together_.end()) together_.push_back(key);
  }
  return value;
}

StudyFileValue Reader::read_value(const std::string& column, const toml::node& node,
                                  const InputPlace& place) {
  const std::string key = scene_key(column, place, true);
  if (std::ranges::find(scene_sections, key) != scene_sections.end()) return read_together(key, node, place);
  StudyFileValue value{.text = shown(node), .overrides = {}, .number = {}};
  if (key == "target_load" || key == "speed") {
    value.number = node.value<double>();
    if (node.is_boolean() || !value.number || !std::isfinite(*value.number) || *value.number <= 0)
      throw InputError(place, fmt::format("holds {}, expected numbers above 0", toml_of(node)));
  } else {
    value.overrides.push_back(key + "=" + rebased(key, node));
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
  for (const toml::node& element : *list) {
    StudyFileValue value = read_value(column, element, where(&element, "vary." + column));
    const auto [other, fresh] =
        seen.try_emplace(element.is_table() ? value.text : identity(key, element), value.text);
    if (!fresh)
      throw InputError(where(&element, "vary." + column),
                       other->second == value.text
                           ? fmt::format("holds '{}' twice, expected each value once", value.text)
                           : fmt::format("holds '{}', which is the same as '{}', expected each value once",
                                         value.text, other->second));
    axis.values.push_back(std::move(value));
  }
  if (together_.empty()) claim(key, axis.where, "varied");
  for (const std::string& one : std::exchange(together_, {})) claim(one, axis.where, "varied");
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
      kept[key] = rebased(key, *value);
      places.try_emplace(key, place);
    }
    StudyFileValue step{.text = label, .overrides = {}, .number = {}};
    for (const auto& [key, value] : kept) step.overrides.push_back(key + "=" + value);
    axis.values.push_back(std::move(step));
  }
  for (const auto& [key, place] : places) claim(key, place, "changed by a step");
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
  const std::vector<std::string> known{"travel", "share", "tolerance", "low", "high"};
  SustainedOptions options;
  double* const places[] = {&options.travel, &options.share, &options.tolerance, &options.low, &options.high};
  for (const auto& [name, value] : in_file_order(*node->as_table())) {
    const InputPlace place = where(value, "sustained." + name);
    const auto found = std::ranges::find(known, name);
    if (found == known.end())
      throw InputError(place, fmt::format("unknown key, did you mean '{}'? Expected one of {}",
                                          nearest_word(name, known), listed(known)));
    const std::optional<double> number = value->is_number() ? value->value<double>() : std::nullopt;
    if (!number || !std::isfinite(*number) || *number <= 0 || (name == "share" && *number > 1))
      throw InputError(place, fmt::format("is {}, expected a number above 0{}", toml_of(*value),
                                          name == "share" ? " and at most 1" : ""));
    *places[found - known.begin()] = *number;
  }
  if (options.low >= options.high)
    throw InputError(where(node, "sustained"),
                     fmt::format("low {} is not below high {}", options.low, options.high));
  claim("speed", where(node, "sustained"), "searched");
  claim("session.seconds", where(node, "sustained"), "given by travel over speed");
  if (const auto load = claimed_.find("target_load"); load != claimed_.end())
    throw InputError(
        where(node, "sustained"),
        fmt::format(
            "searches the speed at which a given number of workers keeps up, but target_load sets what "
            "they keep up with ({}); expected one or the other",
            load->second.second.text()));
  study_.sustained = options;
  study_.sustained_place = where(node, "sustained");
}

void Reader::check_combinations() const {
  double total = static_cast<double>(study_.seeds.size());
  for (const StudyFileAxis& axis : study_.axes) total *= static_cast<double>(axis.values.size());
  if (total > static_cast<double>(most_cells))
    throw InputError(study_.axes.empty() ? where(root_.get("seeds"), "seeds") : study_.axes.back().where,
                     fmt::format("makes {:.4g} cells, expected at most {}", total, most_cells));
}

StudyFile Reader::read() {
  check_root();
  read_scene();
  read_seeds();
  read_steps();
  read_vary();
  read_fixed();
  read_sustained();
  read_set(set_);
  read_baseline();
  check_combinations();
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

StudyFile read_study(const fs::path& file, std::span<const std::string> set) {
  return Reader(file, set).read();
}

InputError located(const StudyFile& study, const InputError& error) {
  if (error.place().option.empty()) return error;
  for (std::string path = error.place().key;;) {
    if (const auto found = study.origin.find(path); found != study.origin.end())
      return {found->second, error.problem()};
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) return error;
    path.resize(dot);
  }
}

}  // namespace forefeel
