#pragma once
// A study (TOML): every combination of what varies, times every seed, each one a session under the virtual
// clock.
//
//   scene = "liver.toml"                   # relative to the study, as are traces and arrivals named in it
//   seeds = [1, 2, 3]
//   baseline = "nearest"                   # optional: a value of the first axis that the others are compared
//   with [session]                              # any section of a scene: keys that are the same in every
//   cell seconds = 10.0 [vary]                                 # a list for each key; the first varies
//   slowest, the seed fastest policy = ["nearest", "coverage"]       # short for session.…: policy select
//   workers device cost switch target_load = [0.5, 1, 2]              # cost = load x workers / demand of the
//   path, spread as the paper's speed = [0.03, 0.06]                   # of path devices [m/s] "model.kernel"
//   = ["cubic", "quintic"]  # any scene key, in quotes material = [{ name = "soft", young = 2e3, poisson =
//   0.4 }, …]   # keys of one section that change together
//   [[step]]                               # instead of or beside [vary]: an ablation. Each step keeps what
//   the name = "predecessor"                   # former ones changed and adds its own keys policy = "nearest"
//   [sustained]                            # each cell searches the highest speed that it sustains
//   (study_speed.hpp)
//
// The clock is virtual whatever the scene says: cells must not depend on wall time. A key may appear once, be
// it varied, stepped, fixed or given by --set.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/common/error.hpp"

namespace forefeel {

struct StudyValue {
  std::string text;                    // as it stands in cells.csv
  std::vector<std::string> overrides;  // "key.path=TOML" for the scene
  std::optional<double> number;        // of `target_load` and `speed`, which are no scene keys
};

struct StudyAxis {
  std::string column;     // as written: "policy", "model.kernel", "load", "step"
  InputPlace where = {};  // study.toml:7: vary.policy
  std::vector<StudyValue> values;
};

// See study_speed.hpp.
struct SustainedOptions {
  double travel = 0.6;             // length of each run [m]; seconds = travel / speed
  double share = 0.95;             // of first-visit frames
  double tolerance = 0.07;         // of the reference force
  double low = 0.005, high = 2.0;  // [m/s]
};

struct Study {
  std::filesystem::path file, scene;
  std::string text;  // of the file
  std::vector<std::uint64_t> seeds;
  std::vector<StudyAxis> axes;
  std::optional<std::size_t> baseline;  // value of axes[0]
  std::vector<std::string> fixed;       // "key.path=TOML"
  std::optional<SustainedOptions> sustained;
  InputPlace scene_place = {}, sustained_place = {};  // study.toml:1: scene
  std::map<std::string, InputPlace> origin;           // scene key -> where it was given, for messages

  std::size_t combinations() const;  // without seeds
  std::size_t cells() const { return combinations() * seeds.size(); }
  // Value of each axis in a combination; the first axis varies slowest.
  std::vector<std::size_t> choice(std::size_t combination) const;
  std::vector<std::string> overrides(std::span<const std::size_t> choice) const;
};

// set: what --set gave. InputError for anything that contradicts itself or cannot be meant.
Study read_study(const std::filesystem::path& file, std::span<const std::string> set);

// An error about an overridden scene key, said with the place in the study that gave the key.
InputError located(const Study& study, const InputError& error);

}  // namespace forefeel
