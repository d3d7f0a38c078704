#include "scheduling/touch/surface_models.hpp"

#include <chrono>
#include <span>
#include <utility>

#include "scheduling/render/input_log.hpp"

namespace forefeel {

SurfaceModels::SurfaceModels(std::shared_ptr<const TouchTask> task) : task_(std::move(task)) {
  models_.push_back(std::make_unique<SurfaceModel>(
      SurfaceModel{.serial = 1,
                   .known = 0,
                   .deep = std::make_shared<const DeepStates>(task_->field, DeepOptions{}, task_->patches)}));
}

void SurfaceModels::learn(const State& state) {
  known_.push_back(state);
}

const SurfaceModel* SurfaceModels::newest() {
  const SurfaceModel& last = *models_.back();
  if (last.known < known_.size())
    models_.push_back(std::make_unique<SurfaceModel>(
        SurfaceModel{.serial = last.serial + 1,
                     .known = static_cast<std::uint32_t>(known_.size()),
                     .deep = last.deep->with(std::span(known_).subspan(last.known))}));
  return models_.back().get();
}

const SurfaceModel* SurfaceModels::made(std::uint64_t serial) const {
  return serial > 0 && serial <= models_.size() ? models_[serial - 1].get() : nullptr;
}

std::vector<std::shared_ptr<const DeepStates>> SurfaceModels::all() const {
  std::vector<std::shared_ptr<const DeepStates>> all;
  for (const auto& model : models_) all.push_back(model->deep);
  return all;
}

void SurfaceMaker::update(double now, const Vec3& hip, bool time_it) {
  const auto before = std::chrono::steady_clock::now();
  const SurfaceModel* newest = models_->newest();
  if (newest == published_) return;
  if (link_.inputs) {
    link_.inputs->learn(models_->known());
    link_.inputs->model({.hip = hip, .states = newest->known, .serial = newest->serial, .published = true});
  }
  const std::uint32_t known_before = published_ ? published_->known : 0;
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - before;
  updates_.push_back({.t = now,
                      .model = newest->serial,
                      .cause = newest->known == 0  ? SwitchCause::guess
                               : known_before == 0 ? SwitchCause::first
                                                   : SwitchCause::states,
                      .n = newest->known,
                      .replaced = newest->known - known_before,
                      .fit_us = time_it ? took.count() : unknown});
  first_used_.resize(newest->known, now);
  published_ = newest;
  link_.surfaces.publish(newest);
}

}  // namespace forefeel
