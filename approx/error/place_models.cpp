#include "approx/error/place_models.hpp"

#include <algorithm>
#include <vector>

namespace forefeel {

namespace {

ModelOptions fewer(ModelOptions options, std::size_t most) {
  options.neighbours = std::min(options.neighbours, most);
  return options;
}

}  // namespace

PlaceModels::PlaceModels(const StateSpace& known, const ModelOptions& options)
    : updater_(known, fewer(options, known.size())) {}

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
  if (!all) return std::make_unique<PlaceModels>(known, options);
  return std::make_unique<OneModel>([&known, options] {
    std::vector<State> states;
    for (std::uint32_t id = 0; id < known.size(); ++id) states.push_back(known[StateId{id}]);
    Vec3 middle = Vec3::Zero();
    for (const State& s : states) middle += s.at / static_cast<double>(states.size());
    return std::make_unique<const Model>(fit_model(states, options, middle));
  });
}

PlaceForces::PlaceForces(const StateSpace& known, const PlaceMethod& method) {
  const bool same = method.field && method.judge && same_process(*method.field, *method.judge);
  if (method.field && !same) field_.emplace(known, *method.field);
  if (!method.field) models_ = models_of(known, method.model, method.all);
  if (method.judge) judge_.emplace(known, *method.judge);
}

PlaceForces::Found PlaceForces::at(const Vec3& x) {
  Found found;
  if (judge_) found.judged = judge_->at(x);
  if (field_) {
    found.force = field_->at(x).force;
  } else if (models_) {
    const Vec3 foot = found.judged ? found.judged->foot : x;
    found.force = models_->at({foot}).force(Place{foot});
  } else {
    found.force = found.judged->force;
  }
  return found;
}

}  // namespace forefeel
