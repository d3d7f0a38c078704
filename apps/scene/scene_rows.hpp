#pragma once
// The keys of one table of a scene. A row declares a key once: name, unit, accepted values, meaning, and the member of
// Options that it sets; the member's usual value is the default. From the rows come reading and its errors, `forefeel
// help scene`, and the keys that --set and studies accept.
//
//   const SceneRows<LimitOptions>& limit_rows() {
//     static const auto rows = SceneRows<LimitOptions>("session.limits", "Safety rules.")
//         .number("force", "N", positive(), "largest force sent", &LimitOptions::force);
//     return rows;
//   }
//   limit_rows().read(session.sub("limits", limit_rows().names()), limits);

#include <fmt/format.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "apps/scene/option_names.hpp"
#include "apps/scene/scene_table.hpp"
#include "geometry/common/declared.hpp"
#include "scheduling/common/arguments.hpp"

namespace forefeel {

// A member of a member: path(&Scene::session, &SessionOptions::seed)(scene) is scene.session.seed.
template <class First, class... Rest>
constexpr auto path(First first, Rest... rest) {
  return [=](auto& of) -> auto& {
    if constexpr (sizeof...(Rest) == 0)
      return of.*first;
    else
      return path(rest...)(of.*first);
  };
}

// A usual value as help shows it.
inline std::string in_scene(double value) {
  return fmt::format("{}", value);
}
inline std::string in_scene(bool value) {
  return value ? "true" : "false";
}
template <class Whole>
requires std::is_integral_v<Whole> std::string in_scene(Whole value) {
  return std::to_string(value);
}
inline std::string in_scene(const Registered& part) {
  return part.name;
}
template <class Value>
std::string in_scene(const std::optional<Value>& value) {
  return value ? in_scene(*value) : "";
}

// A registered name, perhaps with settings: "mine:gain=2". InputError for another name.
Registered part_of(const SceneTable& table, const std::string& key, const std::vector<std::string>& names);

// The value of a member, which may be optional.
template <class Value>
struct Held {
  using Type = Value;
};
template <class Value>
struct Held<std::optional<Value>> {
  using Type = Value;
};

// What does not depend on the options.
class SceneRowList {
 public:
  const std::string& name() const { return tables_.front().name; }
  std::vector<std::string> names() const { return names_of(tables_.front().rows); }
  const std::vector<DeclaredTable>& tables() const { return tables_; }  // this one, then those in it
  // Keys that exclude each other: an override of one removes the others.
  const std::vector<std::string>& alternatives() const { return alternatives_; }
  // Keys that only control which states are solved, by which worker and when.
  const std::vector<std::string>& of_solving() const { return of_solving_; }
  // InputError for a required key that is missing.
  void check_required(const SceneTable& table) const;

 protected:
  SceneRowList(std::string name, std::string meaning) : tables_{{std::move(name), std::move(meaning), {}}} {}
  Declared& last() { return tables_.front().rows.back(); }

  std::vector<DeclaredTable> tables_;
  std::vector<std::string> alternatives_, of_solving_;
  std::vector<std::pair<std::string, std::string>> required_;  // key, what is expected
};

template <class Options>
class SceneRows : public SceneRowList {
 public:
  using Reader = std::function<void(const SceneTable&, const std::string& key, Options&)>;

  SceneRows(std::string name, std::string meaning, Options usual = {})
      : SceneRowList(std::move(name), std::move(meaning)), usual_(std::move(usual)) {}

  // ---- rows

  template <class Member>
  SceneRows number(const std::string& key, const std::string& unit, const Interval& interval,
                   const std::string& meaning, Member member) && {
    return std::move(*this).set({key, unit, usual(member), meaning}, member,
                                [=](const SceneTable& table) { return *table.number(key, interval); });
  }
  template <class Member>
  SceneRows whole(const std::string& key, std::int64_t low, std::int64_t high, const std::string& meaning,
                  Member member) && {
    return std::move(*this).set({key, "", usual(member), meaning}, member,
                                [=](const SceneTable& table) { return *table.integer(key, low, high); });
  }
  template <class Member>
  SceneRows flag(const std::string& key, const std::string& meaning, Member member) && {
    return std::move(*this).set({key, "", usual(member), meaning}, member,
                                [=](const SceneTable& table) { return *table.boolean(key); });
  }
  template <class Member>
  SceneRows text(const std::string& key, const std::string& meaning, Member member) && {
    return std::move(*this).set({key, "", "", meaning}, member,
                                [=](const SceneTable& table) { return *table.text(key); });
  }
  // One of these words; help lists them before the meaning.
  template <class Choice, class Member>
  SceneRows word(const std::string& key, const Words<Choice>& words, const std::string& meaning,
                 Member member) && {
    const std::string usual_word = word_of(words, std::invoke(member, usual_));
    return std::move(*this).set({key, "", usual_word, in_words(words) + meaning}, member,
                                [=](const SceneTable& table) { return *table.word(key, words); });
  }
  // registered(): those known when the scene is read.
  template <class Member>
  SceneRows part(const std::string& key, std::vector<std::string> (*registered)(), const std::string& meaning,
                 Member member) && {
    return std::move(*this).set({key, "", usual(member), in_words(registered()) + meaning}, member,
                                [=](const SceneTable& table) { return part_of(table, key, registered()); });
  }
  // Any other key. Without a reader, the code that needs its value asks the table for it.
  SceneRows row(Declared declared, Reader reader = {}) && {
    readers_.emplace_back(declared.name, std::move(reader));
    tables_.front().rows.push_back(std::move(declared));
    return std::move(*this);
  }
  // A table in this one, named "<this one>.<key>".
  template <class Inner, class Member>
  SceneRows table(const std::string& key, const std::string& meaning, const SceneRows<Inner>& inner,
                  Member member) && {
    inner_.push_back([=, &inner](const SceneTable& table, Options& options) {
      inner.read(table.sub(key, inner.names()), std::invoke(member, options));
    });
    return std::move(*this).row({key, "", "", meaning}).within(inner);
  }
  // Rows of a part of the options; their keys are of this table.
  template <class Part, class Member>
  SceneRows rows(const SceneRows<Part>& part, Member member) && {
    std::vector<Declared>& all = tables_.front().rows;
    all.insert(all.end(), part.tables().front().rows.begin(), part.tables().front().rows.end());
    of_solving_.insert(of_solving_.end(), part.of_solving().begin(), part.of_solving().end());
    inner_.push_back([=, &part](const SceneTable& table, Options& options) {
      part.read(table, std::invoke(member, options));
    });
    return std::move(*this);
  }

  // ---- of the row before

  SceneRows standard(std::string text) && {  // in place of the member's usual value
    last().standard = std::move(text);
    return std::move(*this);
  }
  SceneRows required(std::string expected) && {
    required_.emplace_back(last().name, std::move(expected));
    last().standard = "required";
    return std::move(*this);
  }
  // Required unless the body is a phantom. `with_phantom` stands for the usual value in help.
  SceneRows required_with_mesh(std::string expected) && {
    required_.emplace_back(last().name, std::move(expected));
    last().standard = "required; with a phantom " + last().standard;
    return std::move(*this);
  }
  SceneRows alternative() && {
    alternatives_.push_back(last().name);
    return std::move(*this);
  }
  SceneRows within(const SceneRowList& inner) && {  // its key is a table with these rows
    tables_.insert(tables_.end(), inner.tables().begin(), inner.tables().end());
    return std::move(*this);
  }
  SceneRows only_solving() && {
    of_solving_.push_back(last().name);
    return std::move(*this);
  }

  // ---- use

  // Sets the members whose keys the table has, in the order of the rows.
  void read(const SceneTable& table, Options& options) const {
    for (const auto& [key, reader] : readers_)
      if (table.has(key) && reader) reader(table, key, options);
    for (const auto& inner : inner_) inner(table, options);
  }

 private:
  template <class Member>
  std::string usual(Member member) const {
    return in_scene(std::invoke(member, usual_));
  }
  template <class Member, class Get>
  SceneRows set(Declared declared, Member member, Get get) && {
    return std::move(*this).row(std::move(declared),
                                [=](const SceneTable& table, const std::string&, Options& options) {
                                  auto& value = std::invoke(member, options);
                                  using Value = typename Held<std::decay_t<decltype(value)>>::Type;
                                  value = static_cast<Value>(get(table));
                                });
  }

  Options usual_;
  std::vector<std::pair<std::string, Reader>> readers_;
  std::vector<std::function<void(const SceneTable&, Options&)>> inner_;
};

}  // namespace forefeel
