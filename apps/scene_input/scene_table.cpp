#include "apps/scene_input/scene_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "apps/console/suggest.hpp"

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

// A TOML number, integer or float; NaN where it is something else.
double number_of(const toml::node& node) {
  if (const auto* value = node.as_floating_point()) return value->get();
  if (const auto* value = node.as_integer()) return static_cast<double>(value->get());
  return std::numeric_limits<double>::quiet_NaN();
}

std::optional<Vec3> vector_of(const toml::node* node) {
  const toml::array* list = node ? node->as_array() : nullptr;
  if (!list || list->size() != 3) return {};
  Vec3 value;
  for (std::size_t i = 0; i < 3; ++i) value[static_cast<Eigen::Index>(i)] = number_of((*list)[i]);
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

SceneTable::SceneTable(const toml::table* table, std::string path, std::string file,
                       const std::set<std::string>& overridden, std::vector<std::string> known)
    : table_(table), path_(std::move(path)), file_(std::move(file)), overridden_(&overridden) {
  if (!table) return;
  for (const auto& [key, value] : *table) {
    const std::string name(key.str());
    if (std::ranges::find(known, name) != known.end()) continue;
    const std::string prefix = path_.empty() ? "" : path_ + ".";
    throw InputError(where(name), fmt::format("unknown key, did you mean '{}{}'? Expected one of {}", prefix,
                                              nearest_word(name, known), listed(known)));
  }
}

InputPlace SceneTable::where(const std::string& key) const {
  for (std::string path = full(key);;) {
    if (overridden_->contains(path)) return {.option = "--set", .key = full(key)};
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) break;
    path.resize(dot);
  }
  const toml::node* value = node(key);
  if (value && value->source().begin)
    return {.file = file_, .line = value->source().begin.line, .key = full(key)};
  const std::string below = full(key) + ".";  // a table that only overrides speak of
  const bool made =
      std::ranges::any_of(*overridden_, [&](const std::string& path) { return path.starts_with(below); });
  return made ? InputPlace{.option = "--set", .key = full(key)} : InputPlace{.file = file_, .key = full(key)};
}

InputPlace SceneTable::place() const {
  if (table_ && table_->source().begin)
    return {.file = file_, .line = table_->source().begin.line, .key = path_};
  if (table_ && !table_->empty())
    return where(std::string(table_->begin()->first.str()));  // made by overrides
  return {.file = file_, .key = path_};
}

InputError SceneTable::wrong(const std::string& key, const std::string& expected) const {
  const toml::node* value = node(key);
  return {where(key), fmt::format("{}, expected {}", value ? "is " + shown(*value) : "missing", expected)};
}

std::optional<double> SceneTable::number(const std::string& key, const Interval& interval) const {
  const toml::node* value = node(key);
  if (!value) return {};
  const double number = number_of(*value);
  const bool inside = (interval.open_low ? number > interval.low : number >= interval.low) &&
                      (interval.open_high ? number < interval.high : number <= interval.high);
  if (!inside || !std::isfinite(number)) throw wrong(key, interval.text);
  return number;
}

std::optional<std::int64_t> SceneTable::integer(const std::string& key, std::int64_t low,
                                                std::int64_t high) const {
  const toml::node* value = node(key);
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
  const toml::node* value = node(key);
  if (!value) return {};
  if (!value->is_boolean()) throw wrong(key, "true or false");
  return value->as_boolean()->get();
}

std::optional<std::string> SceneTable::text(const std::string& key) const {
  const toml::node* value = node(key);
  if (!value) return {};
  if (!value->is_string() || value->as_string()->get().empty()) throw wrong(key, "a text");
  return value->as_string()->get();
}

bool SceneTable::is_text(const std::string& key, std::string_view value) const {
  const toml::node* given = node(key);
  return given && given->is_string() && given->as_string()->get() == value;
}

std::optional<Vec3> SceneTable::vector(const std::string& key) const {
  if (!has(key)) return {};
  const std::optional<Vec3> value = vector_of(node(key));
  if (!value) throw wrong(key, "three finite numbers [x, y, z]");
  return value;
}

std::optional<std::vector<std::int64_t>> SceneTable::integers(const std::string& key) const {
  const toml::node* value = node(key);
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
  const toml::node* value = node(key);
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
  const toml::node* value = node(key);
  if (value && !value->is_table()) throw wrong(key, "a table");
  return {value ? value->as_table() : nullptr, full(key), file_, *overridden_, std::move(known)};
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
                        const std::vector<std::string>& words) {
  const auto found = std::ranges::find(words, text);
  if (found == words.end())
    throw table.wrong(key,
                      fmt::format("one of {} (nearest: '{}')", listed(words), nearest_word(text, words)));
  return static_cast<std::size_t>(found - words.begin());
}

}  // namespace forefeel
