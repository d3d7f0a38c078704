#include "scheduling/session/surprises.hpp"

#include <algorithm>
#include <limits>
#include <memory>

#include "scheduling/render/session_model.hpp"
#include "scheduling/session/planner_setup.hpp"
#include "scheduling/touch/surface_models.hpp"

namespace forefeel {

namespace {

std::function<Vec3(const State&)> predicted_by(const PlannerSetup& setup, const StateSpace& space) {
  if (setup.surface)
    return [models = setup.surface](const State& state) {
      FieldOfSites field = models->task().field_of_sites();
      field.use(models->latest()->deep.get());
      return field.at(field.map().nearest(state.site), state.at, false).at.force;
    };
  return [model = std::make_shared<SessionModel>(space, setup.model)](const State& state) {
    model->forget();
    return model->model_at(state.at).force(state.at);
  };
}

}  // namespace

Surprises::Surprises(const StateSpace& space, const PlannerSetup& setup)
    : space_(space), predicted_(predicted_by(setup, space)), jnd_(setup.jnd) {}

// Measures all of the first states. Later the estimate changes little, and one state in eight is measured.
void Surprises::note(const State& state, const Vec3& at) {
  constexpr std::size_t all = 64, every = 8;
  if (space_.empty() || space_.find(at).valid()) return;
  if (space_.size() > all && space_.size() % every != 0) return;
  const Vec3 error = predicted_(state) - state.force;
  errors_.resize(space_.size(), std::numeric_limits<float>::quiet_NaN());
  errors_.push_back(
      static_cast<float>(error.norm() / std::max(jnd_.jnd_share * state.force.norm(), jnd_.jnd_floor)));
}

double JetEstimates::operator()(const Vec3& x) {
  const Answer found = models_.at({x}).at({x});
  return found.error / std::max(jnd_.jnd_share * found.force.norm(), jnd_.jnd_floor);
}

}  // namespace forefeel
