#include "apps/study/study_keys.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <vector>

#include "apps/console/suggest.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/study/study_toml.hpp"

namespace forefeel::study_keys {

namespace fs = std::filesystem;
using study_toml::toml_of;

namespace {

// Short words for keys of the scene, and keys that only a study has.
struct ShortKey {
  Declared declared;
  bool of_scene = true;  // "policy" stands for "session.policy"
};

const std::vector<ShortKey>& short_keys() {
  static const std::vector<ShortKey> keys{
      {{"policy", "", "", "session.policy: what is solved next"}},
      {{"select", "", "", "session.select: rule that chooses the neighbours"}},
      {{"workers", "", "", "session.workers: workers that solve"}},
      {{"device", "", "",
        "session.device: each value is a trace, the unit of the statistics; \"trace:traces/*.csv\" stands "
        "for "
        "each file that matches"}},
      {{"cost", "", "", "session.cost: time of a solve"}},
      {{"switch", "", "", "session.switch: how the force changes from one model to the next"}},
      {{"target_load", "1", "",
        "states that the motion needs / states that the workers solve; sets the cost"},
       false},
      {{"speed", "m/s", "", "speed of a path device"}, false}};
  return keys;
}

std::vector<std::string> words(bool only_of_scene) {
  std::vector<std::string> names;
  for (const ShortKey& key : short_keys())
    if (key.of_scene || !only_of_scene) names.push_back(key.declared.name);
  return names;
}

}  // namespace

DeclaredTable declared_vary() {
  DeclaredTable table{"vary", "A list of values for each key; every combination is run.", {}};
  for (const ShortKey& key : short_keys()) table.rows.push_back(key.declared);
  table.rows.push_back(
      {"\"model.kernel\" …", "", "", "any key of the scene, in quotes (forefeel help scene)"});
  table.rows.push_back(
      {"model, session …", "", "",
       "tables of keys that change together: { name = \"r3\", kernel = \"cubic\", neighbours = 100 }"});
  return table;
}

DeclaredTable declared_step() {
  return {"step",
          "[[step]] tables: each keeps what the ones before it changed, so that steps add up.",
          {{"name", "", "required", "as printed"},
           {"policy, \"model.kernel\" …", "", "",
            "any key of the scene, as in vary; not target_load and speed"}}};
}

const std::vector<SustainedKey>& sustained_keys() {
  using Options = SustainedOptions;
  const Options usual;
  const auto shown = [](double value) { return fmt::format("{}", value); };
  static const std::vector<SustainedKey> keys{
      {{"travel", "m", shown(usual.travel), "length of each run; it takes travel / speed"}, &Options::travel},
      {{"share", "1", shown(usual.share), "of first visits that must be within the tolerance"},
       &Options::share},
      {{"tolerance", "1", shown(usual.tolerance), "of the reference force"}, &Options::tolerance},
      {{"low", "m/s", shown(usual.low), "lowest speed tried"}, &Options::low},
      {{"high", "m/s", shown(usual.high), "highest speed tried"}, &Options::high}};
  return keys;
}

DeclaredTable declared_sustained() {
  DeclaredTable table{"sustained", "Each cell searches the highest speed that it sustains.", {}};
  for (const SustainedKey& key : sustained_keys()) table.rows.push_back(key.declared);
  return table;
}

std::string scene_key(const std::string& written, const InputPlace& place, bool pseudo_allowed) {
  for (const ShortKey& key : short_keys())
    if (key.declared.name == written && (key.of_scene || pseudo_allowed))
      return key.of_scene ? "session." + written : written;
  if (written == "model.select") return "session.select";  // one and the same
  const std::string section = written.substr(0, written.find('.'));
  const bool dotted = section.size() + 1 < written.size();
  const bool known = is_scene_section(section);
  if (dotted && known) return written;
  if (dotted)
    throw InputError(place, "unknown section" + expected_instead(section, scene_sections(), "",
                                                                 written.substr(section.size())));
  if (pseudo_allowed && known && section == written) return written;
  throw InputError(place, fmt::format("unknown key{}, or a scene key in quotes (\"model.kernel\")",
                                      expected_instead(written, words(!pseudo_allowed))));
}

void ClaimedKeys::claim(const std::string& key, const InputPlace& place, const std::string& how) {
  const auto within = [](const std::string& inner, const std::string& outer) {
    return inner == outer || inner.starts_with(outer + ".");
  };
  for (const auto& [other, given] : claimed_) {
    const bool cost_twice = (key == "target_load" && other == "session.cost") ||
                            (key == "session.cost" && other == "target_load");
    if (within(key, other) || within(other, key) || cost_twice)
      throw InputError(place, fmt::format("{}, but {} is {} ({}); expected it once", how, other, given.first,
                                          given.second.text()));
    // Those of one axis take turns.
    const bool in_turn = place == given.second || (how == "changed by a step" && how == given.first);
    if (exclude_each_other(key, other) && !in_turn && place.option.empty())
      throw InputError(place, fmt::format("{}, but {} is {} ({}); expected one of the two", how, other,
                                          given.first, given.second.text()));
  }
  if (key == "session.clock" && how != "fixed")
    throw InputError(place, "the clock of a study is virtual, so that its cells repeat; it cannot be varied");
  claimed_[key] = {how, place};
}

bool ClaimedKeys::unfix(const std::string& key) {
  const auto found = claimed_.find(key);
  if (found == claimed_.end() || found->second.first != "fixed") return false;
  claimed_.erase(found);
  return true;
}

const InputPlace* ClaimedKeys::place_of(const std::string& key) const {
  const auto found = claimed_.find(key);
  return found == claimed_.end() ? nullptr : &found->second.second;
}

std::map<std::string, InputPlace> ClaimedKeys::places() const {
  std::map<std::string, InputPlace> places;
  for (const auto& [key, given] : claimed_) places[key] = given.second;
  return places;
}

namespace {

// Where in the text of a value a file is named; nothing where it names none.
struct FileIn {
  std::size_t begin, end;
};
std::optional<FileIn> file_in(const std::string& key, const std::string& value) {
  if (key == "session.arrivals" || key == "body.mesh") return FileIn{0, value.size()};
  if (key == "state_space.design" && value.starts_with("list:")) return FileIn{5, value.size()};
  if (key == "session.device" && value.starts_with("trace:"))
    return FileIn{6, std::min(value.find(','), value.size())};
  return {};
}

}  // namespace

std::string rebased(const StudyPaths& study, const std::string& key, const toml::node& node) {
  const auto* text = node.as_string();
  const std::optional<FileIn> part = text ? file_in(key, text->get()) : std::nullopt;
  if (!part) return toml_of(node);
  const auto moved = [&](const std::string& file) -> std::string {
    const fs::path beside = study.file.parent_path() / file;
    if (file.empty() || fs::path(file).is_absolute() || !fs::exists(beside)) return file;
    const fs::path folder = fs::absolute(study.scene).parent_path();
    return fs::proximate(fs::absolute(beside).lexically_normal(), folder.lexically_normal()).string();
  };
  const std::string& value = text->get();
  return toml_of(toml::value<std::string>(value.substr(0, part->begin) +
                                          moved(value.substr(part->begin, part->end - part->begin)) +
                                          value.substr(part->end)));
}

std::string identity(const StudyPaths& study, const std::string& key, const toml::node& node) {
  if (const auto* number = node.as_integer()) return std::to_string(number->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  const std::string written = rebased(study, key, node);
  if (!node.is_string()) return written;
  const std::string value = toml::parse("value = " + written)["value"].value_or(std::string());
  const std::optional<FileIn> part = file_in(key, value);
  if (!part) return written;
  std::error_code error;
  const fs::path file = fs::weakly_canonical(
      study.scene.parent_path() / value.substr(part->begin, part->end - part->begin), error);
  return error ? written : value.substr(0, part->begin) + file.string() + value.substr(part->end);
}

}  // namespace forefeel::study_keys
