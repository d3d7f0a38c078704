#pragma once
// The keys of a JSON document. A row declares a key once: name, unit, meaning, and how its value is taken from a T.
// From the rows come the document and `forefeel help outputs`.
//
//   const JsonKeys<Region> region_keys{{"name", "", "of its group", &Region::name},
//                                      {"volume", "m^3", "of its elements",
//                                       [](const Region& r) { return r.volume(); }}};
//   Json document = document_of(region_keys, region);
//   DeclaredTable help{"region.json", "Of region --json.", declared(region_keys)};
//
// Names: objects are joined by dots ("error.p95"). Keys that share a row share its meaning ("error.p50,p95"); their
// values are an array. A part in capitals stands for any name; the value is the object of all. A value of an empty
// std::optional leaves the key out; numbers that are not finite are null.

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "apps/console/json.hpp"
#include "geometry/common/declared.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

using Json = nlohmann::ordered_json;

inline std::optional<Json> json_value(double value) {
  return number(value);
}
inline std::optional<Json> json_value(const Vec3& value) {
  return vector3(value);
}
template <class Value>
std::optional<Json> json_value(const Value& value) {
  return Json(value);
}
template <class Value>
std::optional<Json> json_value(const std::optional<Value>& value) {
  return value ? json_value(*value) : std::nullopt;
}

Json json_numbers(const std::vector<double>& values);  // a list, with null for those that are not finite

// Sets the key, or the keys, of this name.
void put(Json& document, const std::string& name, Json value);
// Rows of help below a key.
std::vector<Declared> below(const std::string& key, std::vector<Declared> rows);

template <class T>
struct JsonKey {
  std::vector<Declared> rows;  // of help
  std::function<void(Json&, const T&)> write;
  bool listed_last = false;  // help lists these rows behind the others

  JsonKey(std::vector<Declared> help, std::function<void(Json&, const T&)> writer)
      : rows(std::move(help)), write(std::move(writer)) {}
  // value: a member of T, or a function of it. Without it, other code writes the key.
  JsonKey(std::string name, std::string unit, std::string meaning)
      : rows{{std::move(name), std::move(unit), "", std::move(meaning)}} {}
  template <class Get>
  JsonKey(const std::string& name, std::string unit, std::string meaning, Get value)
      : rows{{name, std::move(unit), "", std::move(meaning)}}, write([=](Json& document, const T& of) {
          if (std::optional<Json> found = json_value(std::invoke(value, of)))
            put(document, name, std::move(*found));
        }) {}
  JsonKey last() && {
    listed_last = true;
    return std::move(*this);
  }
};
template <class T>
using JsonKeys = std::vector<JsonKey<T>>;

template <class T>
void add_to(Json& document, const JsonKeys<T>& keys, const T& of) {
  for (const JsonKey<T>& key : keys)
    if (key.write) key.write(document, of);
}

template <class T>
Json document_of(const JsonKeys<T>& keys, const T& of) {
  Json document = Json::object();
  add_to(document, keys, of);
  return document;
}

template <class T>
std::vector<Declared> declared(const JsonKeys<T>& keys) {
  std::vector<Declared> rows;
  for (const bool last : {false, true})
    for (const JsonKey<T>& key : keys)
      if (key.listed_last == last) rows.insert(rows.end(), key.rows.begin(), key.rows.end());
  return rows;
}

// A list of objects. entries: of T, a range of Entry; an empty std::optional leaves the list out.
template <class T, class Entry, class Get>
JsonKey<T> json_list(const std::string& name, const JsonKeys<Entry>& keys, Get entries,
                     const std::string& meaning = "") {
  std::vector<Declared> rows = below(name + "[]", declared(keys));
  if (!meaning.empty()) rows.insert(rows.begin(), {name, "", "", meaning});
  return {std::move(rows), [=](Json& document, const T& of) {
            const auto& found = std::invoke(entries, of);
            Json list = Json::array();
            const auto fill = [&](const auto& range) {
              for (const Entry& entry : range) list.push_back(document_of(keys, entry));
            };
            if constexpr (requires { found.has_value(); }) {
              if (!found) return;
              fill(*found);
            } else {
              fill(found);
            }
            put(document, name, std::move(list));
          }};
}

// An object. part: of T, a pointer to what it describes; null: the value is `otherwise`.
template <class T, class Part, class Get>
JsonKey<T> json_object(const std::string& name, const JsonKeys<Part>& keys, const std::string& meaning,
                       Get part, Json otherwise = nullptr) {
  std::vector<Declared> rows = below(name, declared(keys));
  if (!meaning.empty()) rows.insert(rows.begin(), {name, "", "", meaning});
  return {std::move(rows), [=](Json& document, const T& of) {
            const Part* found = std::invoke(part, of);
            put(document, name, found ? document_of(keys, *found) : otherwise);
          }};
}

// Keys of another table at this place of the document. part: of T, a pointer to what they describe; null leaves them
// out. `before` stands in front of their meanings.
template <class T, class Part, class Get>
JsonKey<T> json_part(const JsonKeys<Part>& keys, Get part, const std::string& before = "") {
  std::vector<Declared> rows = declared(keys);
  for (Declared& row : rows) row.meaning = before + row.meaning;
  return {std::move(rows), [=](Json& document, const T& of) {
            if (const Part* found = std::invoke(part, of)) add_to(document, keys, *found);
          }};
}

}  // namespace forefeel
