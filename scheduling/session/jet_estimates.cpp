#include "scheduling/session/jet_estimates.hpp"

#include <algorithm>

namespace forefeel {

double JetEstimates::operator()(const Vec3& x) {
  updater_.forget();  // so that the answer depends on the states alone
  updater_.update(x, model_);
  const JetEstimate found = model_.estimate(x);
  return found.error / std::max(jnd_.jnd_share * found.force.norm(), jnd_.jnd_floor);
}

}  // namespace forefeel
