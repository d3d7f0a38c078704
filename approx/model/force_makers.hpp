#pragma once
// Makers of models (force_model.hpp) for places anywhere:
//   PlaceModels models(space, {.neighbours = 25});
//   models.at({x}).at({x}).force;   // [N]

#include <functional>
#include <memory>

#include "approx/model/updater.hpp"

namespace forefeel {

// A model of the neighbour set of each place.
class PlaceModels final : public ForceMaker {
 public:
  // The space must outlive this; it may grow.
  PlaceModels(const StateSpace& known, const ModelOptions& options) : updater_(known, options) {}
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

// One model of `all` known states, about their middle, or one of each place's neighbours. The space must outlive it.
std::unique_ptr<ForceMaker> models_of(const StateSpace& known, const ModelOptions& options, bool all);

}  // namespace forefeel
