#include "approx/error/place_models.hpp"

namespace forefeel {

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
