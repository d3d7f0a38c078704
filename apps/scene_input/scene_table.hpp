#pragma once
// A scene file as parsed, and its tables: typed reading with one-line errors that name file, line, key and
// what was expected. The parser, toml++, is known to scene_table.cpp alone.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

// Accepted interval of a number; `text` is how a message calls it ("above 0").
struct Interval {
  double low, high;
  bool open_low = false, open_high = false;
  std::string text;
};
Interval positive();
Interval not_negative();
Interval share();  // [0, 1]

class SceneTable {
 public:
  bool has(const std::string& key) const;
  std::optional<double> number(const std::string& key, const Interval& interval) const;
  std::optional<std::int64_t> integer(const std::string& key, std::int64_t low, std::int64_t high) const;
  std::optional<bool> boolean(const std::string& key) const;
  std::optional<std::string> text(const std::string& key) const;
  bool is_text(const std::string& key, std::string_view value) const;  // never throws
  std::optional<Vec3> vector(const std::string& key) const;
  std::optional<std::vector<std::int64_t>> integers(const std::string& key) const;
  std::optional<Box> box(const std::string& key) const;
  // A table in this one; where it is absent all its keys are unset. InputError where the key is no table, or
  // the table has a key that is not in `known`.
  SceneTable sub(const std::string& key, std::vector<std::string> known) const;
  // Throws unless exactly one of the keys is set; returns it.
  std::string exactly_one_of(const std::vector<std::string>& keys) const;
  // One of the words; message lists them.
  template <class Word>
  std::optional<Word> word(const std::string& key,
                           const std::vector<std::pair<std::string, Word>>& words) const;

  InputPlace where(const std::string& key) const;  // liver.toml:9: material.poisson
  InputPlace place() const;                        // of the table itself: liver.toml:7: material
  InputError wrong(const std::string& key, const std::string& expected) const;  // "<where>: <value> is not …"

 private:
  friend class SceneDocument;
  struct Source;  // where its keys are
  SceneTable(std::shared_ptr<const Source> source, const std::vector<std::string>& known);
  std::string full(const std::string& key) const;

  std::shared_ptr<const Source> source_;
};

// A scene file with its overrides. Its tables point into it: they are read while it lives.
class SceneDocument {
 public:
  // overrides: "key.path=value" as given to --set; value is TOML, or a bare string. InputError for a file
  // that is missing or no TOML, and for an override without key or value.
  static SceneDocument read(const std::filesystem::path& file, std::span<const std::string> overrides);
  // name: what messages call the text, in place of a file.
  static SceneDocument parse(std::string_view text, const std::string& name,
                             std::span<const std::string> overrides);
  SceneDocument(SceneDocument&&) noexcept;
  ~SceneDocument();

  SceneTable root(const std::vector<std::string>& known) const;
  // As TOML, as overridden: keys sorted, without comments. The second of one section; nothing where it is
  // absent.
  std::string text() const;
  std::optional<std::string> section_text(const std::string& section) const;

 private:
  struct Parsed;
  explicit SceneDocument(std::unique_ptr<Parsed> parsed);
  std::unique_ptr<Parsed> parsed_;
};

// Helper of word(): the entry that equals text, or the error that lists all.
std::size_t chosen_word(const SceneTable& table, const std::string& key, const std::string& text,
                        const std::vector<std::string>& words);

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
