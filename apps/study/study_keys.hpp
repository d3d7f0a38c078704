#pragma once
// The keys of a study: which key of the scene a word stands for, each given once in one way, and the values
// that name files.

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "apps/study/study_toml.hpp"
#include "geometry/common/declared.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/study/study.hpp"

namespace forefeel::study_keys {

// What `forefeel help study` says of the keys of [vary], of [[step]] and of [sustained].
DeclaredTable declared_vary();
DeclaredTable declared_step();
DeclaredTable declared_sustained();
struct SustainedKey {
  Declared declared;
  double SustainedOptions::*place;
};
const std::vector<SustainedKey>& sustained_keys();

// The sections of a scene that a study may set.
std::span<const std::string> scene_sections();
// "policy" -> "session.policy". pseudo_allowed: also `target_load`, `speed` and whole sections, which are no
// keys of a scene. InputError at `place` for an unknown word.
std::string scene_key(const std::string& written, const InputPlace& place, bool pseudo_allowed);

// How and where each key is given: "fixed", "varied", …
class ClaimedKeys {
 public:
  // InputError where the key is given already. A key and a table that holds it are the same place, and so are
  // the load and the cost it stands for.
  void claim(const std::string& key, const InputPlace& place, const std::string& how);
  bool unfix(const std::string& key);                        // false where it was not "fixed"
  const InputPlace* place_of(const std::string& key) const;  // null where it is not given
  std::map<std::string, InputPlace> places() const;

 private:
  std::map<std::string, std::pair<std::string, InputPlace>> claimed_;  // key -> how, where
};

struct StudyPaths {
  std::filesystem::path file, scene;
};
// The value as TOML. A file named in the study is looked for beside the study first; the scene wants it
// relative to itself.
std::string rebased(const StudyPaths& study, const std::string& key, const toml::node& node);
// The same text for values that are the same however they are written: 2, 2.0 and 0x2; a file by any of its
// names.
std::string identity(const StudyPaths& study, const std::string& key, const toml::node& node);

}  // namespace forefeel::study_keys
