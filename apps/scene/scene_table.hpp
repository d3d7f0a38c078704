#pragma once
// A parsed scene file and its tables. Values are read by type; each error is one line that names file, line,
// key and what was expected. Only toml_table.cpp includes the parser, toml++.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

// Accepted interval of a number; `text` describes it in messages ("above 0").
struct Interval {
  double low, high;
  bool open_low = false, open_high = false;
  std::string text;
};
Interval positive();
Interval not_negative();
Interval share();  // [0, 1]

// Its readers throw std::logic_error for a key that is not among the known ones: such a key could not be set.
class SceneTable {
 public:
  bool has(const std::string& key) const;
  std::optional<double> number(const std::string& key, const Interval& interval) const;
  std::optional<std::int64_t> integer(const std::string& key, std::int64_t low, std::int64_t high) const;
  std::optional<bool> boolean(const std::string& key) const;
  std::optional<std::string> text(const std::string& key) const;
  bool is_text(const std::string& key, std::string_view value) const;  // never throws
  bool holds_text(const std::string& key) const;                       // the value is text; never throws
  bool holds_table(const std::string& key) const;
  std::optional<Vec3> vector(const std::string& key) const;
  std::optional<std::vector<std::int64_t>> integers(const std::string& key) const;
  std::optional<Box> box(const std::string& key) const;
  // A table inside this one; if absent, all its keys are unset. Throws InputError if the key is not a table
  // or the table has a key that is not in `known`.
  SceneTable sub(const std::string& key, std::vector<std::string> known) const;
  // The tables of [[key]], or the one table [key], without keys if it is absent. A table with group = "NAME" has keys
  // like "material.NAME.young" in messages and overrides.
  std::vector<SceneTable> subs(const std::string& key, const std::vector<std::string>& known) const;
  // Throws unless exactly one of the keys is set; returns it.
  std::string exactly_one_of(const std::vector<std::string>& keys) const;
  // Reads one of the words; the error lists them.
  template <class Word>
  std::optional<Word> word(const std::string& key,
                           const std::vector<std::pair<std::string, Word>>& words) const;

  InputPlace where(const std::string& key) const;  // liver.toml:9: material.poisson
  InputPlace place() const;                        // of the table itself: liver.toml:7: material
  InputError wrong(const std::string& key, const std::string& expected) const;  // "<where>: <value> is not …"

 private:
  friend class SceneDocument;
  struct Source;  // places of its keys
  SceneTable(std::shared_ptr<const Source> source, const std::vector<std::string>& known);
  std::string full(const std::string& key) const;

  std::shared_ptr<const Source> source_;
};

// A scene file with its overrides. Its tables share it.
class SceneDocument {
 public:
  // overrides: "key.path=value" as given to --set; value is TOML, or a bare string. Throws InputError
  // if the file is missing or not TOML, or an override lacks key or value.
  static SceneDocument read(const std::filesystem::path& file, std::span<const std::string> overrides);
  // name: used in messages in place of the file name.
  static SceneDocument parse(std::string_view text, const std::string& name,
                             std::span<const std::string> overrides);
  SceneDocument(SceneDocument&&) noexcept;
  ~SceneDocument();

  SceneTable root(const std::vector<std::string>& known) const;
  std::set<std::string> keys_read() const;  // full paths of the keys that readers asked for, set or not
  // The file with its overrides as TOML: keys sorted, no comments. The second function gives one section, or
  // nothing if it is absent.
  std::string text() const;
  std::optional<std::string> section_text(const std::string& section) const;

 private:
  struct Parsed;
  explicit SceneDocument(std::shared_ptr<Parsed> parsed);
  std::shared_ptr<Parsed> parsed_;
};

// Helper of word(): finds the entry equal to text, or throws the error that lists all entries and ends with `more`.
std::size_t chosen_word(const SceneTable& table, const std::string& key, const std::string& text,
                        const std::vector<std::string>& words, std::string_view more = "");

template <class Word>
std::optional<Word> SceneTable::word(const std::string& key,
                                     const std::vector<std::pair<std::string, Word>>& words) const {
  const std::optional<std::string> given = text(key);
  if (!given) return {};
  std::vector<std::string> names;
  for (const auto& [name, value] : words) names.push_back(name);
  return words[chosen_word(*this, key, *given, names)].second;
}

}  // namespace forefeel
