#pragma once
// One table of a scene: typed reading with one-line errors that name file, line, key and what was expected.

#include <toml++/toml.h>

#include <optional>
#include <set>
#include <string>
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
  // table may be null: the section is absent and every key unset. Throws for a key that is not in `known`.
  SceneTable(const toml::table* table, std::string path, std::string file,
             const std::set<std::string>& overridden, std::vector<std::string> known);

  bool has(const std::string& key) const { return table_ && table_->contains(key); }
  std::optional<double> number(const std::string& key, const Interval& interval) const;
  std::optional<std::int64_t> integer(const std::string& key, std::int64_t low, std::int64_t high) const;
  std::optional<bool> boolean(const std::string& key) const;
  std::optional<std::string> text(const std::string& key) const;
  bool is_text(const std::string& key, std::string_view value) const;  // never throws
  std::optional<Vec3> vector(const std::string& key) const;
  std::optional<std::vector<std::int64_t>> integers(const std::string& key) const;
  std::optional<Box> box(const std::string& key) const;
  SceneTable sub(const std::string& key,
                 std::vector<std::string> known) const;  // must be a table where present
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
  const toml::node* node(const std::string& key) const { return table_ ? table_->get(key) : nullptr; }
  std::string full(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }

  const toml::table* table_;
  std::string path_, file_;
  const std::set<std::string>* overridden_;
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
