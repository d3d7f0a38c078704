#pragma once
// Models of known states for places anywhere, as evaluation makes them.

#include <optional>
#include <span>

#include "approx/measured/force_field.hpp"
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

// What gives the force at a place: a Gaussian process of measured forces, or else an RBF model.
struct PlaceMethod {
  ModelOptions model = {};
  bool all = false;                        // one model of all states
  std::optional<FieldOptions> field = {};  // the process (measured/force_field.hpp)
  std::optional<FieldOptions> judge = {};  // of the error and of the directions that the states do not know
};

// Forces of some known states at one place after the other. Where `judge` says that the states do not know a direction
// across them, the force is that of the foot.
class PlaceForces {
 public:
  PlaceForces(const StateSpace& known, const PlaceMethod& method);  // the space must outlive this
  struct Found {
    Vec3 force = Vec3::Zero();                          // [N]
    std::optional<ForceField::Prediction> judged = {};  // none without a judge
  };
  Found at(const Vec3& x);

 private:
  std::optional<PlaceModels> models_;
  std::optional<ForceField> field_, judge_;
};

}  // namespace forefeel
