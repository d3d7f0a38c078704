#include "apps/scene/scene_table.hpp"

#include <fmt/format.h>

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>

#include "apps/console/provenance.hpp"
#include "apps/console/suggest.hpp"
#include "apps/scene/toml_text.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/segmentation/label_volume.hpp"

namespace forefeel {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string shown(const toml::node& node) {
  std::ostringstream out;
  node.visit([&](const auto& value) {
    if constexpr (toml::is_table<decltype(value)>)
      out << "a table";
    else if constexpr (toml::is_array<decltype(value)>)
      out << "a list of " << value.size();
    else if constexpr (toml::is_string<decltype(value)>)
      out << '\'' << value.get() << '\'';
    else if constexpr (toml::is_boolean<decltype(value)>)
      out << (value.get() ? "true" : "false");
    else
      out << value.get();
  });
  return out.str();
}

// A TOML integer or float; NaN for any other value.
double number_of(const toml::node& node) {
  if (const auto* value = node.as_floating_point()) return value->get();
  if (const auto* value = node.as_integer()) return static_cast<double>(value->get());
  return std::numeric_limits<double>::quiet_NaN();
}

std::optional<Vec3> vector_of(const toml::node* node) {
  const toml::array* list = node ? node->as_array() : nullptr;
  if (!list || list->size() != 3) return {};
  Vec3 value;
  for (unsigned i = 0; i < 3; ++i) value[i] = number_of((*list)[i]);
  if (!value.allFinite()) return {};
  return value;
}

}  // namespace

Interval positive() {
  return {0, infinity, true, true, "a number above 0"};
}
Interval not_negative() {
  return {0, infinity, false, true, "a number of at least 0"};
}
Interval share() {
  return {0, 1, false, false, "a number from 0 to 1"};
}

struct SceneTable::Source {
  const toml::table* table;  // null if the section is absent; then every key is unset
  std::string path, file;
  const std::set<std::string>* overridden;  // key paths
  std::set<std::string>* asked;             // key paths that readers asked for
  std::vector<std::string> known;
  std::shared_ptr<const void> document;  // that the pointers point into

  const toml::node* given(const std::string& key) const { return table ? table->get(key) : nullptr; }
  // For readers of the value.
  const toml::node* node(const std::string& key) const {
    const std::string full = path.empty() ? key : path + "." + key;
    if (std::ranges::find(known, key) == known.end())
      throw std::logic_error("the key " + full + " is read but not declared (scene_declared.hpp)");
    asked->insert(full);
    return given(key);
  }
};

SceneTable::SceneTable(std::shared_ptr<const Source> source, const std::vector<std::string>& known)
    : source_(std::move(source)) {
  if (!source_->table) return;
  for (const auto& [key, value] : *source_->table) {
    const std::string name(key.str());
    if (std::ranges::find(known, name) != known.end()) continue;
    throw InputError(where(name), "unknown key" + expected_instead(name, known, full("")));
  }
}

std::string SceneTable::full(const std::string& key) const {
  return source_->path.empty() ? key : source_->path + "." + key;
}

bool SceneTable::has(const std::string& key) const {
  return source_->node(key) != nullptr;
}

InputPlace SceneTable::where(const std::string& key) const {
  for (std::string path = full(key);;) {
    if (source_->overridden->contains(path)) return {.option = "--set", .key = full(key)};
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) break;
    path.resize(dot);
  }
  const toml::node* value = source_->given(key);
  if (value && value->source().begin)
    return {.file = source_->file, .line = value->source().begin.line, .key = full(key)};
  const std::string below = full(key) + ".";  // a table that only overrides mention
  const bool made = std::ranges::any_of(*source_->overridden,
                                        [&](const std::string& path) { return path.starts_with(below); });
  return made ? InputPlace{.option = "--set", .key = full(key)}
              : InputPlace{.file = source_->file, .key = full(key)};
}

InputPlace SceneTable::place() const {
  if (source_->table && source_->table->source().begin)
    return {.file = source_->file, .line = source_->table->source().begin.line, .key = source_->path};
  if (source_->table && !source_->table->empty())
    return where(std::string(source_->table->begin()->first.str()));  // made by overrides
  return {.file = source_->file, .key = source_->path};
}

InputError SceneTable::wrong(const std::string& key, const std::string& expected) const {
  const toml::node* value = source_->given(key);
  return {where(key), fmt::format("{}, expected {}", value ? "is " + shown(*value) : "missing", expected)};
}

std::optional<double> SceneTable::number(const std::string& key, const Interval& interval) const {
  const toml::node* value = source_->node(key);
  if (!value) return {};
  const double number = number_of(*value);
  const bool inside = (interval.open_low ? number > interval.low : number >= interval.low) &&
                      (interval.open_high ? number < interval.high : number <= interval.high);
  if (!inside || !std::isfinite(number)) throw wrong(key, interval.text);
  return number;
}

std::optional<std::int64_t> SceneTable::integer(const std::string& key, std::int64_t low,
                                                std::int64_t high) const {
  const toml::node* value = source_->node(key);
  if (!value) return {};
  const auto* integer = value->as_integer();
  if (!integer || integer->get() < low || integer->get() > high)
    throw wrong(key, high < std::numeric_limits<std::int64_t>::max()
                         ? fmt::format("a whole number from {} to {}", low, high)
                     : low > std::numeric_limits<std::int64_t>::min()
                         ? fmt::format("a whole number of at least {}", low)
                         : "a whole number");
  return integer->get();
}

std::optional<bool> SceneTable::boolean(const std::string& key) const {
  const toml::node* value = source_->node(key);
  if (!value) return {};
  if (!value->is_boolean()) throw wrong(key, "true or false");
  return value->as_boolean()->get();
}

std::optional<std::string> SceneTable::text(const std::string& key) const {
  const toml::node* value = source_->node(key);
  if (!value) return {};
  if (!value->is_string() || value->as_string()->get().empty()) throw wrong(key, "a text");
  return value->as_string()->get();
}

bool SceneTable::is_text(const std::string& key, std::string_view value) const {
  const toml::node* given = source_->node(key);
  return given && given->is_string() && given->as_string()->get() == value;
}

bool SceneTable::holds_text(const std::string& key) const {
  const toml::node* given = source_->node(key);
  return given && given->is_string();
}

bool SceneTable::holds_table(const std::string& key) const {
  const toml::node* given = source_->node(key);
  return given && given->is_table();
}

std::optional<Vec3> SceneTable::vector(const std::string& key) const {
  if (!has(key)) return {};
  const std::optional<Vec3> value = vector_of(source_->node(key));
  if (!value) throw wrong(key, "three finite numbers [x, y, z]");
  return value;
}

std::optional<std::vector<std::int64_t>> SceneTable::integers(const std::string& key) const {
  const toml::node* value = source_->node(key);
  if (!value) return {};
  const toml::array* list = value->as_array();
  if (!list || list->empty()) throw wrong(key, "a list of whole numbers, not empty");
  std::vector<std::int64_t> numbers;
  for (const toml::node& element : *list) {
    if (!element.is_integer()) throw wrong(key, "a list of whole numbers, got " + shown(element) + " in it");
    numbers.push_back(element.as_integer()->get());
  }
  return numbers;
}

std::optional<Box> SceneTable::box(const std::string& key) const {
  const toml::node* value = source_->node(key);
  if (!value) return {};
  const std::string expected = "[[x0, y0, z0], [x1, y1, z1]], finite, low corner first";
  const toml::array* corners = value->as_array();
  if (!corners || corners->size() != 2) throw wrong(key, expected);
  const std::optional<Vec3> low = vector_of(corners->get(0)), high = vector_of(corners->get(1));
  if (!low || !high) throw wrong(key, expected);
  if ((low->array() > high->array()).any())
    throw InputError(
        where(key),
        fmt::format(
            "is inverted: [{:g}, {:g}, {:g}] is not below [{:g}, {:g}, {:g}] on every axis, expected {}",
            (*low)[0], (*low)[1], (*low)[2], (*high)[0], (*high)[1], (*high)[2], expected));
  return Box{*low, *high};
}

SceneTable SceneTable::sub(const std::string& key, std::vector<std::string> known) const {
  const toml::node* value = source_->node(key);
  if (value && !value->is_table()) throw wrong(key, "a table");
  return {std::make_shared<Source>(Source{value ? value->as_table() : nullptr, full(key), source_->file,
                                          source_->overridden, source_->asked, known, source_->document}),
          known};
}

std::vector<SceneTable> SceneTable::subs(const std::string& key,
                                         const std::vector<std::string>& known) const {
  const toml::node* value = source_->node(key);
  if (!value || value->is_table()) return {sub(key, known)};
  const toml::array* list = value->as_array();
  if (!list || list->empty() || !list->is_homogeneous<toml::table>())
    throw wrong(key, fmt::format("a table, or a list of tables: [[{}]]", full(key)));
  std::vector<SceneTable> tables;
  for (const toml::node& element : *list) {
    const std::optional<std::string_view> group = group_of(element);
    const std::string path = group ? full(key) + "." + std::string(*group) : full(key);
    tables.push_back(
        {std::make_shared<Source>(Source{element.as_table(), path, source_->file, source_->overridden,
                                         source_->asked, known, source_->document}),
         known});
  }
  return tables;
}

std::string SceneTable::exactly_one_of(const std::vector<std::string>& keys) const {
  std::vector<std::string> given;
  for (const std::string& key : keys)
    if (has(key)) given.push_back(key);
  if (given.size() == 1) return given.front();
  const std::string found = given.empty() ? "none given" : listed(given) + " given";
  throw InputError(given.empty() ? place() : where(given.back()),
                   found + ", expected exactly one of " + listed(keys));
}

std::size_t chosen_word(const SceneTable& table, const std::string& key, const std::string& text,
                        const std::vector<std::string>& words, std::string_view more) {
  const auto found = std::ranges::find(words, text);
  if (found == words.end()) {
    const std::string near = nearest_word(text, words);
    throw table.wrong(key, fmt::format("one of {}{}{}", listed(words),
                                       near.empty() ? "" : fmt::format(" (nearest: '{}')", near), more));
  }
  return static_cast<std::size_t>(found - words.begin());
}

// ---- the document ----

namespace {

namespace fs = std::filesystem;

// A body is not a scene yet: names the command that makes its mesh.
void refuse_mesh(const fs::path& file) {
  if (!fs::is_regular_file(file)) return;
  if (!is_mesh_file(file) && !is_surface_file(file) && !is_label_volume_file(file)) return;
  const std::string body = file.stem().string() + (file.extension() == ".msh" ? "-mesh.msh" : ".msh");
  throw InputError(
      {.file = file.string()},
      fmt::format("is a shape, expected a scene (TOML); forefeel mesh {} -o {} makes a mesh for its "
                  "key body.mesh",
                  shell_quoted(file.string()), shell_quoted(body)));
}

toml::table parse_scene(const fs::path& file) {
  if (!fs::exists(file)) throw InputError({.file = file.string()}, "no such file, expected a scene (TOML)");
  refuse_mesh(file);
  return parse_toml(read_toml(file, "a scene"), file);
}

std::string as_toml(const toml::table& table) {
  std::ostringstream text;
  text << toml::toml_formatter(table);
  return text.str();
}

}  // namespace

struct SceneDocument::Parsed {
  toml::table table;
  std::string file;
  std::set<std::string> overridden, asked;

  Parsed(toml::table parsed, std::string name, std::span<const std::string> overrides)
      : table(std::move(parsed)), file(std::move(name)) {
    for (const std::string& text : overrides) override_key(table, text, overridden);
  }
};

SceneDocument::SceneDocument(std::shared_ptr<Parsed> parsed) : parsed_(std::move(parsed)) {}
SceneDocument::SceneDocument(SceneDocument&&) noexcept = default;
SceneDocument::~SceneDocument() = default;

SceneDocument SceneDocument::read(const fs::path& file, std::span<const std::string> overrides) {
  return SceneDocument(std::make_shared<Parsed>(parse_scene(file), file.string(), overrides));
}

SceneDocument SceneDocument::parse(std::string_view text, const std::string& name,
                                   std::span<const std::string> overrides) {
  return SceneDocument(std::make_shared<Parsed>(parse_toml(text, name), name, overrides));
}

SceneTable SceneDocument::root(const std::vector<std::string>& known) const {
  using Source = SceneTable::Source;
  return {std::make_shared<Source>(Source{&parsed_->table, "", parsed_->file, &parsed_->overridden,
                                          &parsed_->asked, known, parsed_}),
          known};
}

std::set<std::string> SceneDocument::keys_read() const {
  return parsed_->asked;
}

std::string SceneDocument::text() const {
  return as_toml(parsed_->table);
}

std::optional<std::string> SceneDocument::section_text(const std::string& section) const {
  const toml::node* node = parsed_->table.get(section);
  if (node && node->is_array()) {  // [[section]]
    toml::table alone;
    alone.insert(section, *node->as_array());
    return as_toml(alone);
  }
  if (!node || !node->is_table()) return {};
  return as_toml(*node->as_table());
}

}  // namespace forefeel
