#include "tests/support/json_keys.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <sstream>

#include "apps/main/help_topics.hpp"

namespace forefeel::test {
namespace {

using nlohmann::json;
using Keys = std::set<std::string>;

// The keys of a document, joined by dots; "[]" is each entry of a list of objects.
void collect(const json& value, const std::string& path, Keys& keys) {
  if (value.is_object() && !value.empty()) {
    for (const auto& [key, inner] : value.items())
      collect(inner, path.empty() ? key : path + "." + key, keys);
  } else if (value.is_array() && !value.empty() && value[0].is_object()) {
    for (const json& entry : value) collect(entry, path + "[]", keys);
  } else {
    keys.insert(path);
  }
}

std::vector<std::string> parts_of(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, at);) parts.push_back(part);
  return parts;
}

// "error.p50,p95,error.max" -> error.p50, error.p95, error.max: names without a dot take the prefix of the first.
std::vector<std::string> single(const std::string& declared) {
  std::vector<std::string> names = parts_of(declared, ',');
  const std::size_t dot = names.front().rfind('.');
  for (std::size_t i = 1; i < names.size(); ++i)
    if (names[i].find('.') == std::string::npos && dot != std::string::npos)
      names[i] = names.front().substr(0, dot + 1) + names[i];
  return names;
}

bool is_any_name(const std::string& word) {
  return std::ranges::all_of(word, [](unsigned char c) { return std::isupper(c) != 0; });
}

// "NAME" is any word, "NAME[]" any word that ends so.
bool stands_for(const std::string& declared, const std::string& word) {
  const bool list = declared.ends_with("[]");
  return word == declared ||
         (list ? word.ends_with("[]") && is_any_name(declared.substr(0, declared.size() - 2))
               : is_any_name(declared));
}

// A word in capitals stands for any name; a declared LABEL, KEY or NAME also for what is below it.
bool matches(const std::string& key, const std::string& declared) {
  const std::vector<std::string> mine = parts_of(key, '.'), theirs = parts_of(declared, '.');
  if (mine.size() < theirs.size()) return false;
  for (std::size_t i = 0; i < theirs.size(); ++i)
    if (!stands_for(theirs[i], mine[i])) return false;
  return mine.size() == theirs.size() || is_any_name(theirs.back());
}

// The names in a table and in those nested in it.
std::vector<std::string> listed(const std::vector<DeclaredTable>& tables, const std::string& table) {
  std::vector<std::string> names;
  for (const DeclaredTable& one : tables_named({"", "", tables}, table))
    for (const Declared& row : one.rows)
      for (const std::string& name : single(row.name)) names.push_back(name);
  return names;
}

}  // namespace

void compare_keys(const std::vector<DeclaredTable>& tables, const std::string& table,
                  const std::vector<json>& documents, const std::set<std::string>& rare) {
  INFO(table);
  const std::vector<std::string> declared = listed(tables, table);
  REQUIRE(!declared.empty());
  Keys printed;
  for (const json& document : documents) collect(document, "", printed);
  Keys missing, never;
  for (const std::string& key : printed)
    if (std::ranges::none_of(declared, [&](const std::string& name) { return matches(key, name); }))
      missing.insert(key);
  for (const std::string& name : declared)
    if (!rare.contains(name) &&
        std::ranges::none_of(printed, [&](const std::string& key) { return matches(key, name); }))
      never.insert(name);
  CHECK(missing == Keys{});
  CHECK(never == Keys{});
}

}  // namespace forefeel::test
