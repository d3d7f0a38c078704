#pragma once
// The rows of `reproduce speed`: from the paper's predecessor (nearest states first, polynomials on the
// lattice, at the spacings that suit them) through the seed paper to our default, one change at a time; then
// our default with single changes, and the others with our start.

#include <string>
#include <utility>
#include <vector>

#include "scheduling/session/session.hpp"

namespace forefeel {

// What a step may change.
struct SpeedSettings {
  SessionOptions options;
  double spacing = 0.006;  // of the lattice [m]
};

// What a row stands for where rows are compared; several lattices of the predecessor share a role.
enum class SpeedRole {
  predecessor,
  seed_paper_best,  // on the lattice that suits it best
  seed_paper,
  ours,                   // the default
  rest_known,             // the default with rest known before the start
  predecessor_start,      // with our start: first guess and rest first
  seed_paper_best_start,  // the same
  seed_paper_start,       // the same
  other
};

struct SpeedStep {
  std::string name;
  SpeedRole role;
  bool drawn;  // has a curve in the picture
  void (*change)(SpeedSettings&);
};

const std::vector<SpeedStep>& speed_steps();
// The settings of each step: it keeps what earlier steps changed.
std::vector<SpeedSettings> speed_settings(const SpeedSettings& begin);

// What steps may change, as keys of a scene with their values in TOML.
std::vector<std::pair<std::string, std::string>> scene_keys(const SpeedSettings& settings);
// Name of the first step that changes this key of a scene, with or without its section; empty: none does.
std::string step_that_changes(const std::string& key);

}  // namespace forefeel
