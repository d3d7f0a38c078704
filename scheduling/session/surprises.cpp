#include "scheduling/session/surprises.hpp"

#include <algorithm>
#include <limits>

namespace forefeel {

// Measures all of the first states. Later the estimate changes little, and one state in eight is measured.
void Surprises::note(const State& state) {
  constexpr std::size_t all = 64, every = 8;
  if (space_.empty() || space_.find(state.at).valid()) return;
  if (space_.size() > all && space_.size() % every != 0) return;
  model_.forget();
  const Vec3 error = model_.model_at(state.at).force(state.at) - state.force;
  errors_.resize(space_.size(), std::numeric_limits<float>::quiet_NaN());
  errors_.push_back(
      static_cast<float>(error.norm() / std::max(jnd_.jnd_share * state.force.norm(), jnd_.jnd_floor)));
}

}  // namespace forefeel
