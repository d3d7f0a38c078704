#pragma once
// The keys of a study: which scene key each word means, the check that each key is given only once, and values that are
// file names.

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "apps/study/study_toml.hpp"
#include "geometry/common/declared.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/study/study.hpp"

namespace forefeel::study_keys {

// The tables of `forefeel help study` for the keys of [vary], [[step]] and [sustained].
DeclaredTable declared_vary();
DeclaredTable declared_step();
DeclaredTable declared_sustained();
struct SustainedKey {
  Declared declared;
  double SustainedOptions::*place;
};
const std::vector<SustainedKey>& sustained_keys();

// "policy" -> "session.policy". pseudo_allowed: also `target_load`, `speed` and whole sections, which are no
// keys of a scene. InputError at `place` for an unknown word.
std::string scene_key(const std::string& written, const InputPlace& place, bool pseudo_allowed);

// Records how ("fixed", "varied", …) and where each key is given.
class ClaimedKeys {
 public:
  // InputError if the key was given before. A key also conflicts with a table that contains it, and target_load with
  // the cost.
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
// The value as TOML. A file name in the study is looked up in the study's folder first; the result is relative to the
// scene's folder, as the scene reader expects.
std::string rebased(const StudyPaths& study, const std::string& key, const toml::node& node);
// A text that is the same for equal values however they are written: 2, 2.0 and 0x2; a file under any of its names.
std::string identity(const StudyPaths& study, const std::string& key, const toml::node& node);

}  // namespace forefeel::study_keys
