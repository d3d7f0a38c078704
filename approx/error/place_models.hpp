#pragma once
// Models of known states for places anywhere, as evaluation makes them.

#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "approx/measured/force_field.hpp"
#include "approx/model/updater.hpp"

namespace forefeel {

// Models of a neighbour set of each place.
class PlaceModels final : public ForceMaker {
 public:
  // The space must outlive this.
  PlaceModels(const StateSpace& known, const ModelOptions& options);
  const Model& at(const Place& place, UpdateReport* report = nullptr) override;

 private:
  ModelUpdater updater_;
  Model model_;
};

// One model for all places, made at the first of them.
class OneModel final : public ForceMaker {
 public:
  using Make = std::function<std::unique_ptr<const ForceModel>()>;
  explicit OneModel(Make make) : make_(std::move(make)) {}
  const ForceModel& at(const Place& place, UpdateReport* report = nullptr) override;

 private:
  Make make_;
  std::unique_ptr<const ForceModel> model_;
};

// Of `all` states one model, or of each place's neighbours. The space must outlive it.
std::unique_ptr<ForceMaker> models_of(const StateSpace& known, const ModelOptions& options, bool all);

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
  std::unique_ptr<ForceMaker> models_;  // null: a process
  std::optional<ForceField> field_, judge_;
};

}  // namespace forefeel
