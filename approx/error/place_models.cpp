#include "approx/error/place_models.hpp"

#include <algorithm>
#include <vector>

namespace forefeel {

Model model_of_all(std::span<const State> states, const ModelOptions& options) {
  Vec3 middle = Vec3::Zero();
  for (const State& s : states) middle += s.at / static_cast<double>(states.size());
  return fit_model(states, options, middle);
}

PlaceModels::PlaceModels(const StateSpace& known, ModelOptions options, bool all) {
  if (all) {
    std::vector<State> states;
    for (std::uint32_t id = 0; id < known.size(); ++id) states.push_back(known[StateId{id}]);
    model_ = model_of_all(states, options);
  } else {
    options.neighbours = std::min(options.neighbours, known.size());
    updater_.emplace(known, options);
  }
}

const Model& PlaceModels::at(const Vec3& x) {
  if (updater_) {
    updater_->forget();
    updater_->update(x, model_);
  }
  return model_;
}

PlaceForces::PlaceForces(const StateSpace& known, const PlaceMethod& method) {
  const bool same = method.field && method.judge && same_process(*method.field, *method.judge);
  if (method.field && !same) field_.emplace(known, *method.field);
  if (!method.field) models_.emplace(known, method.model, method.all);
  if (method.judge) judge_.emplace(known, *method.judge);
}

PlaceForces::Found PlaceForces::at(const Vec3& x) {
  Found found;
  if (judge_) found.judged = judge_->at(x);
  if (field_) {
    found.force = field_->at(x).force;
  } else if (models_) {
    const Vec3 foot = found.judged ? found.judged->foot : x;
    found.force = models_->at(foot).force(foot);
  } else {
    found.force = found.judged->force;
  }
  return found;
}

}  // namespace forefeel
