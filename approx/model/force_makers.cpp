#include "approx/model/force_makers.hpp"

#include <algorithm>
#include <vector>

namespace forefeel {

const Model& PlaceModels::at(const Place& place, UpdateReport* report) {
  updater_.forget();
  updater_.update(place.x, model_, report);
  return model_;
}

const ForceModel& OneModel::at(const Place&, UpdateReport* report) {
  if (report) *report = {.refit = !model_};
  if (!model_) model_ = make_();
  return *model_;
}

std::unique_ptr<ForceMaker> models_of(const StateSpace& known, const ModelOptions& options, bool all) {
  if (!all) {
    ModelOptions of_known = options;
    of_known.neighbours = std::min(options.neighbours, known.size());
    return std::make_unique<PlaceModels>(known, of_known);
  }
  return std::make_unique<OneModel>([&known, options] {
    std::vector<State> states;
    for (std::uint32_t id = 0; id < known.size(); ++id) states.push_back(known[StateId{id}]);
    Vec3 middle = Vec3::Zero();
    for (const State& s : states) middle += s.at / static_cast<double>(states.size());
    return std::make_unique<const Model>(fit_model(states, options, middle));
  });
}

}  // namespace forefeel
