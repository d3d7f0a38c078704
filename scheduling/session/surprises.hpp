#pragma once
// How far the model missed each state before it was known, in JNDs (PlannerView::surprises). One thread owns them.

#include <functional>
#include <span>
#include <vector>

#include "approx/model/force_makers.hpp"
#include "approx/switch/force_switch.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

struct PlannerSetup;

class Surprises {
 public:
  Surprises(const StateSpace& space, const PlannerSetup& setup);  // the space must outlive them

  // Before it is inserted into the space at this place.
  void note(const State& state, const Vec3& at);
  std::span<const float> by_id() const { return errors_; }

 private:
  const StateSpace& space_;
  std::function<Vec3(const State&)> predicted_;  // by the models so far, at the state's place [N]
  SwitchOptions jnd_;
  std::vector<float> errors_;
};

// What a model of energy jets says of its own error at a place, in JNDs (just noticeable differences), trust included:
// PlannerView::estimate. One thread owns it.

class JetEstimates {
 public:
  // The space must outlive this.
  JetEstimates(const StateSpace& space, const ModelOptions& model, const SwitchOptions& jnd)
      : models_(space, model), jnd_(jnd) {}

  double operator()(const Vec3& x);  // NaN while no state has a jet

 private:
  PlaceModels models_;  // the answer depends on the states alone
  SwitchOptions jnd_;
};

}  // namespace forefeel
