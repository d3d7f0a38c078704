#pragma once
// A study file (TOML), from which a Study (scheduling/study/study.hpp) is made.
//
//   scene = "liver.toml"            # relative to the study, as are traces and arrivals that it names; or a list of
//                                   # scenes in one folder, which varies fastest
//   seeds = [1, 2, 3]
//   traces = "table"                # optional: the half of the files of a pattern in `device` (study_traces.hpp)
//   baseline = "nearest"            # optional: the value of the first axis that the others are compared with
//
//   [session]                       # any section of a scene: keys that are the same in every cell
//   seconds = 10.0
//
//   [vary]                          # a list for each key; the first varies slowest, the seed fastest
//   policy = ["nearest", "coverage"]     # short for session.…: policy select workers device cost switch
//   target_load = [0.5, 1, 2]            # cost = load x workers / demand of the path, spread as the paper's
//   speed = [0.03, 0.06]                 # of path devices [m/s]
//   "model.kernel" = ["cubic", "quintic"]                          # any scene key, in quotes
//   material = [{ name = "soft", young = 2e3, poisson = 0.4 }, …]  # keys of one section that change together
//   contact = [{ name = "beam", nearest = [1.0, 0.0, 0.0], "body.phantom" = "beam" }, …]   # and of others, in full
//
//   [[step]]                        # instead of [vary] or beside it: an ablation
//   name = "predecessor"            # each step keeps what earlier steps changed and adds its own keys
//   policy = "nearest"
//
//   [sustained]                     # each cell searches the highest speed that it sustains (sustained_speed.hpp)
//
// A session ends with its motion: a trace of 3 s gives a session of 3 s and a trace of 60 s one of 60 s, whatever
// session.seconds is in the scene. If the study itself gives session.seconds, that is an upper limit. Paths and hands
// never end; they run for session.seconds.
// The clock is always virtual, because cells must not depend on wall time. A key may be given only once: varied,
// stepped, fixed or by --set.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/common/declared.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/study/study.hpp"

namespace forefeel {

struct StudyFileValue {
  std::string text;                    // as in cells.csv
  std::vector<std::string> overrides;  // "key.path=TOML" for the scene
  std::optional<double> number;        // of `target_load` and `speed`, which are not keys of a scene
  std::filesystem::path scene = {};    // of the axis `scene`; else empty
};

struct StudyFileAxis {
  std::string column;     // as written: "policy", "model.kernel", "target_load", "step"
  InputPlace where = {};  // study.toml:7: vary.policy
  std::vector<StudyFileValue> values;
};

struct StudyFile {
  std::filesystem::path file, scene;  // scene: the first of a list
  std::string text;                   // of the file
  std::vector<std::uint64_t> seeds;
  std::vector<StudyFileAxis> axes;
  std::optional<std::size_t> baseline;  // value of axes[0]
  std::vector<std::string> fixed;       // "key.path=TOML"
  std::optional<SustainedOptions> sustained;
  InputPlace scene_place = {}, sustained_place = {};  // study.toml:1: scene
  std::map<std::string, InputPlace> origin;           // scene key -> where it was given, for messages

  Study study() const;
  const std::filesystem::path& scene_of(std::span<const std::size_t> choice) const;
  // Of that scene, for a value of each axis.
  std::vector<std::string> overrides(std::span<const std::size_t> choice) const;
};

// set: the values of --set. InputError for contradictory or meaningless input.
StudyFile read_study(const std::filesystem::path& file, std::span<const std::string> set);

// Every key of a study, for `forefeel help study`.
std::vector<DeclaredTable> study_tables();

}  // namespace forefeel
