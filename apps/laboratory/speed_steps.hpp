#pragma once
// The rows of `reproduce speed`, one change at a time: from the paper's predecessor (nearest states first,
// polynomials on the lattice, at their best spacings) through the seed paper to our default. Then our default
// with single changes, and the older methods with our start (first guess and rest first).

#include <string>
#include <utility>
#include <vector>

#include "scheduling/session/session.hpp"

namespace forefeel {

// The settings that a step may change.
struct SpeedSettings {
  SessionOptions options;
  double spacing = 0.006;  // of the lattice [m]
};

// Role of a row in comparisons. Rows of one method on different lattices share a role.
enum class SpeedRole {
  predecessor,
  seed_paper_best,  // on its best lattice
  seed_paper,
  ours,                   // the default
  rest_known,             // the default, with the state at rest known from the start
  predecessor_start,      // with our start: first guess and rest first
  seed_paper_best_start,  // the same
  seed_paper_start,       // the same
  other
};

struct SpeedStep {
  std::string name;
  SpeedRole role;
  bool drawn;  // true if the picture has a curve of it
  void (*change)(SpeedSettings&);
};

const std::vector<SpeedStep>& speed_steps();
// The settings of each step, including the changes of all earlier steps.
std::vector<SpeedSettings> speed_settings(const SpeedSettings& begin);

// The settings as keys of a scene with their values in TOML.
std::vector<std::pair<std::string, std::string>> scene_keys(const SpeedSettings& settings);
// Name of the first step that changes this key of a scene (with or without its section); empty if none does.
std::string step_that_changes(const std::string& key);

}  // namespace forefeel
