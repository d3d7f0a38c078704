#pragma once
// A table from names to factories, built-in and the user's. Any thread may use it at any time, even before
// main() begins: each table is made at its first use.

#include <fmt/format.h>

#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/common/error.hpp"
#include "scheduling/common/arguments.hpp"

namespace forefeel {

template <class Factory>
class Registry {
 public:
  // kind: for errors, as "policy".
  Registry(std::string kind, std::map<std::string, Factory> built_in)
      : kind_(std::move(kind)), factories_(std::move(built_in)) {}

  // InputError for a name that is taken or that a scene cannot express.
  void add(const std::string& name, Factory factory) {
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
        kind_, fmt::format("unknown {} '{}', expected one of {}", kind_, name, fmt::join(names(), ", ")));
  }

 private:
  std::string kind_;
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
