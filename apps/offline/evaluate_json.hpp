#pragma once
// The result of `forefeel evaluate`, and the document that it prints with --json.

#include <algorithm>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "approx/methods/evaluate.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/scene/scene_mesh_error.hpp"

namespace forefeel {

// What `forefeel evaluate` prints.
struct EvaluateResult {
  std::vector<Vec3> points;
  Evaluation found;
  std::optional<Belonging> belonging;
  std::optional<MeshError> mesh;
  std::string value = {};  // name of what the states tell instead of a force

  // The error to expect, relative to the largest of the forces; unknown where no model was chosen.
  double shown() const {
    double largest = 0;
    for (const Vec3& f : found.made.forces) largest = std::max(largest, f.norm());
    return found.chosen && largest > 0 ? found.chosen->p95 / largest : unknown;
  }
};

nlohmann::ordered_json to_json(const EvaluateResult& evaluated);

}  // namespace forefeel
