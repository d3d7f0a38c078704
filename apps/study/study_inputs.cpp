#include "apps/study/study_inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "apps/console/suggest.hpp"
#include "apps/study/study_keys.hpp"
#include "apps/study/study_toml.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;
using study_toml::toml_of;

InputPlace place_of(const toml::node* node, const fs::path& study, const char* key = "scene") {
  InputPlace place{.file = study.string(), .key = key};
  if (node && node->source().begin) place.line = node->source().begin.line;
  return place;
}

fs::path scene_of(const toml::node& node, const fs::path& study) {
  if (!node.is_string())
    throw InputError(place_of(&node, study),
                     fmt::format("is {}, expected the file of a scene", toml_of(node)));
  fs::path scene = study.parent_path() / node.as_string()->get();
  if (!fs::is_regular_file(scene))
    throw InputError(
        place_of(&node, study),
        fmt::format("no such file '{}', expected a scene, relative to the study", scene.string()));
  return scene;
}

}  // namespace

std::vector<fs::path> study_scenes(const toml::node* node, const fs::path& study) {
  const toml::array* list = node ? node->as_array() : nullptr;
  if (!node || (list && list->empty()))
    throw InputError(place_of(node, study), "missing, expected the file of a scene, or a list of them");
  if (!list) return {scene_of(*node, study)};
  std::vector<fs::path> scenes;
  for (const toml::node& element : *list) {
    const fs::path scene = scene_of(element, study);
    for (const fs::path& other : scenes) {
      if (other.stem() == scene.stem())
        throw InputError(place_of(&element, study),
                         fmt::format("holds '{}' twice, expected each once", scene.stem().string()));
      if (other.parent_path() != scene.parent_path())
        throw InputError(place_of(&element, study),
                         fmt::format("'{}' is in another folder than '{}', expected scenes of one folder",
                                     scene.string(), other.string()));
    }
    scenes.push_back(scene);
  }
  return scenes;
}

std::vector<std::uint64_t> study_seeds(const toml::node* node, const fs::path& study) {
  std::vector<std::uint64_t> seeds;
  const toml::array* list = node ? node->as_array() : nullptr;
  if (node && !list)
    throw InputError(place_of(node, study, "seeds"),
                     fmt::format("is {}, expected a list of whole numbers, as [1, 2]", toml_of(*node)));
  if (!list) throw InputError(place_of(node, study, "seeds"), "missing, expected a list of whole numbers");
  if (list->empty())
    throw InputError(place_of(node, study, "seeds"), "is empty, expected at least one whole number");
  for (const toml::node& element : *list) {
    if (!element.is_integer() || element.as_integer()->get() < 0)
      throw InputError(place_of(&element, study, "seeds"),
                       fmt::format("holds {}, expected whole numbers of at least 0", toml_of(element)));
    const auto seed = static_cast<std::uint64_t>(element.as_integer()->get());
    if (std::ranges::find(seeds, seed) != seeds.end())
      throw InputError(place_of(&element, study, "seeds"),
                       fmt::format("holds {} twice, expected each seed once", seed));
    seeds.push_back(seed);
  }
  return seeds;
}

SustainedOptions study_sustained(const toml::table& table, const fs::path& study) {
  const std::vector<study_keys::SustainedKey>& keys = study_keys::sustained_keys();
  std::vector<std::string> known;
  for (const study_keys::SustainedKey& key : keys) known.push_back(key.declared.name);
  SustainedOptions options;
  for (const auto& [name, value] : study_toml::in_file_order(table)) {
    const InputPlace place = place_of(value, study, ("sustained." + name).c_str());
    const auto found = std::ranges::find(known, name);
    if (found == known.end()) throw InputError(place, "unknown key" + expected_instead(name, known));
    const std::optional<double> number = value->is_number() ? value->value<double>() : std::nullopt;
    if (!number || !std::isfinite(*number) || *number <= 0 || (name == "share" && *number > 1))
      throw InputError(place, fmt::format("is {}, expected a number above 0{}", toml_of(*value),
                                          name == "share" ? " and at most 1" : ""));
    options.*keys[static_cast<std::size_t>(found - known.begin())].place = *number;
  }
  if (options.low >= options.high)
    throw InputError(place_of(&table, study, "sustained"),
                     fmt::format("low {} is not below high {}", options.low, options.high));
  return options;
}

}  // namespace forefeel
