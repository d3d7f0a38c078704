#pragma once
// A table from names to factories, built-in and the user's. Any thread may use it at any time, even before
// main() begins: each table is made at its first use.

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/common/declared.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/common/arguments.hpp"

namespace forefeel {

template <class Factory>
class Registry {
 public:
  struct BuiltIn {
    const char* name;
    Factory factory;
    const char* meaning;
  };

  // kind: for errors, as "policy". reserved: names that are built in without a factory.
  Registry(std::string kind, const std::vector<BuiltIn>& built_in, std::vector<std::string> reserved = {})
      : kind_(std::move(kind)), reserved_(std::move(reserved)) {
    for (const BuiltIn& one : built_in) {
      factories_.emplace(one.name, one.factory);
      declared_.push_back({one.name, "", "", one.meaning});
    }
  }

  // InputError for a name that is taken or that a scene cannot express.
  void add(const std::string& name, Factory factory) {
    if (std::ranges::find(reserved_, name) != reserved_.end())
      throw InputError("register " + kind_, fmt::format("'{}' is built in, expected another name", name));
    if constexpr (requires { factory == nullptr; })
      if (factory == nullptr) throw InputError("register " + kind_, fmt::format("'{}' has no factory", name));
    if (name.empty() || name.find_first_of(":,= \t\n\"'") != std::string::npos)
      throw InputError(
          "register " + kind_,
          fmt::format("'{}' cannot be a name, expected one without space, quote, ':', ',' and '='", name));
    const std::lock_guard lock(mutex_);
    if (!factories_.emplace(name, std::move(factory)).second)
      throw InputError("register " + kind_,
                       fmt::format("'{}' is registered already, expected another name", name));
  }

  std::vector<std::string> names() const {  // sorted
    const std::lock_guard lock(mutex_);
    std::vector<std::string> names;
    for (const auto& entry : factories_) names.push_back(entry.first);
    return names;
  }

  bool is_built_in(const std::string& name) const {
    return std::ranges::find(declared_, name, &Declared::name) != declared_.end();
  }
  // The built-in ones with their meanings, then the others.
  std::vector<Declared> declared() const {
    std::vector<Declared> rows = declared_;
    for (const std::string& name : names())
      if (!is_built_in(name)) rows.push_back({name, "", "", "registered by this program"});
    return rows;
  }

  std::optional<Factory> find(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = factories_.find(name);
    if (found == factories_.end()) return {};
    return found->second;
  }

  // Throws InputError for an unknown name; the error lists the known ones.
  Factory at(const std::string& name) const {
    if (auto factory = find(name)) return *std::move(factory);
    throw InputError(
        kind_,
        fmt::format("unknown {} '{}', expected one of {}; one that a program registers exists in it alone",
                    kind_, name, fmt::join(names(), ", ")));
  }

 private:
  std::string kind_;
  std::vector<std::string> reserved_;
  std::vector<Declared> declared_;
  std::map<std::string, Factory> factories_;
  mutable std::mutex mutex_;
};

// Calls a factory for a part as the user wrote it. InputError for a setting that the factory does not know, and for
// what the factory throws; the error names the part.
template <class Factory, class Context>
auto make_registered(const Factory& factory, const std::string& kind, const Registered& part,
                     Context context) {
  const InputPlace where{.key = kind, .value = to_text(part)};
  context.arguments = Arguments(where, part.settings);
  const auto made_by = [&] {
    try {
      return factory(context);
    } catch (const InputError& error) {
      if (error.place() == where) throw;  // names the part already
      throw InputError(where, error.what());
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& problem) {
      throw InputError(where, fmt::format("its factory failed: {}", problem.what()));
    } catch (...) {
      throw InputError(where, "its factory threw what is no std::exception");
    }
  };
  auto made = made_by();
  context.arguments.expect_all_read();
  if (!made) throw InputError(where, "its factory made nothing");
  return made;
}

}  // namespace forefeel
