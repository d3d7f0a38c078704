#pragma once
// Models of known states for places anywhere, as evaluation makes them.

#include <optional>
#include <span>

#include "approx/model/updater.hpp"

namespace forefeel {

// One model of all states, about their middle.
Model model_of_all(std::span<const State> states, const ModelOptions& options);

// The models of some known states at one place after the other: each of its own neighbour set, or one of all states.
class PlaceModels {
 public:
  // The space must outlive this.
  PlaceModels(const StateSpace& known, ModelOptions options, bool all);
  const Model& at(const Vec3& x);  // valid until the next call

 private:
  std::optional<ModelUpdater> updater_;  // none: one model of all
  Model model_;
};

}  // namespace forefeel
