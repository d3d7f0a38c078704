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

Model* ModelKeeper::Pool::take(LoopLink& link) {
  while (const auto returned = link.returned.pop()) put(*returned);
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
  const bool grown = space_.size() > last_.states, travelled = (hip - last_.at).norm() >= travel_;
  if (!(grown || (travelled && !space_.empty()) || !published_.newest)) return;
  bars_.learn(published_.newest);
  Model* model = pool_.take(link_);
  if (!model) return;  // try again at the next call
  const auto before = std::chrono::steady_clock::now();
  UpdateReport report;
  if (link_.inputs) link_.inputs->learn(space_);
  const bool known = updater_.update(hip, *model, &report);
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - before;
  const SwitchCause cause = space_.empty()      ? SwitchCause::guess
                            : last_.states == 0 ? SwitchCause::first
                            : grown             ? SwitchCause::states
                                                : SwitchCause::travel;
  // The same set gives the same model, unless it was stepped down to the state nearest to the HIP.
  const bool changed = report.refit || report.replaced > 0 || report.n != published_.n ||
                       !published_.newest || model->is_tangent();
  last_ = {.at = hip, .states = space_.size(), .label = report.label};
  if (known) bars_.publish(hip, *model);
  if (link_.inputs)
    link_.inputs->model({.hip = hip,
                         .states = static_cast<std::uint32_t>(space_.size()),
                         .serial = known ? model->serial() : 0,
                         .published = known && changed});
  if (!known || !changed) return pool_.put(model);
  publish(model, {.t = now,
                  .model = static_cast<std::uint32_t>(model->serial()),
                  .cause = cause,
                  .label = report.label,
                  .n = static_cast<std::uint32_t>(report.n),
                  .replaced = static_cast<std::uint32_t>(report.replaced),
                  .fit_us = time_it ? took.count() : unknown});
}

void ModelKeeper::publish(const Model* model, const SwitchRecord& record) {
  published_ = {.newest = model, .n = record.n};
  updates_.push_back(record);
  first_used_.resize(space_.size(), unknown);
  for (const StateId id : model->states())
    if (std::isnan(first_used_[id.value])) first_used_[id.value] = record.t;
  if (const auto missed = link_.models.publish(model); missed && *missed) pool_.put(*missed);  // never taken
}

}  // namespace forefeel
