#include "scheduling/render/model_keeper.hpp"

#include <chrono>
#include <cmath>

#include "scheduling/render/input_log.hpp"

namespace forefeel {

ModelKeeper::ModelKeeper(const StateSpace& space, const ModelRecipe& recipe, LoopLink& link)
    : space_(space),
      link_(link),
      travel_(recipe.update_travel * space.options().spacing),
      updater_(space, recipe),
      bars_(space, recipe.guess, link) {}

Model* ModelKeeper::free_model() {
  while (const auto returned = link_.returned.pop()) free_.push_back(const_cast<Model*>(*returned));
  if (free_.empty() &&
      models_.size() < 6) {  // two in the loop, one published, one filled, two on their way back
    models_.push_back(std::make_unique<Model>());
    free_.push_back(models_.back().get());
  }
  if (free_.empty()) return nullptr;
  Model* model = free_.back();
  free_.pop_back();
  return model;
}

void ModelKeeper::update(double now, const Vec3& hip, bool time_it) {
  const bool grown = space_.size() > updated_states_, travelled = (hip - updated_at_).norm() >= travel_;
  if (!(grown || (travelled && !space_.empty()) || !published_)) return;
  bars_.learn(newest_);
  Model* model = free_model();
  if (!model) return;  // the loop has not given one back yet: try again at the next call
  const auto before = std::chrono::steady_clock::now();
  UpdateReport report;
  if (link_.inputs) link_.inputs->learn(space_);
  const bool known = updater_.update(hip, *model, &report);
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - before;
  const SwitchCause cause = space_.empty()         ? SwitchCause::guess
                            : updated_states_ == 0 ? SwitchCause::first
                            : grown                ? SwitchCause::states
                                                   : SwitchCause::travel;
  // The same set gives the same model, unless it was stepped down to the state nearest to the HIP.
  const bool changed =
      report.refit || report.replaced > 0 || report.n != updated_n_ || !published_ || model->is_tangent();
  updated_states_ = space_.size();
  updated_at_ = hip;
  label_ = report.label;
  if (known) bars_.publish(hip, *model);
  if (link_.inputs)
    link_.inputs->model({.hip = hip,
                         .states = static_cast<std::uint32_t>(space_.size()),
                         .serial = known ? model->serial() : 0,
                         .published = known && changed});
  if (!known || !changed) {
    free_.push_back(model);
    return;
  }
  published_ = true;
  newest_ = model;
  updated_n_ = static_cast<std::uint32_t>(report.n);
  SwitchRecord record{.t = now, .model = static_cast<std::uint32_t>(model->serial()), .cause = cause};
  record.label = report.label;
  record.n = updated_n_;
  record.replaced = static_cast<std::uint32_t>(report.replaced);
  if (time_it) record.fit_us = took.count();
  updates_.push_back(record);
  first_used_.resize(space_.size(), unknown);
  for (const StateId id : model->states())
    if (std::isnan(first_used_[id.value])) first_used_[id.value] = now;
  if (const auto missed = link_.models.publish(model)) {
    if (*missed) free_.push_back(const_cast<Model*>(*missed));  // never taken
  }
}

}  // namespace forefeel
