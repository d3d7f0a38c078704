#pragma once
// What a model of energy jets says of its own error at a place, in JNDs (just noticeable differences), trust included:
// PlannerView::estimate. One thread owns it.

#include "approx/model/updater.hpp"
#include "approx/switch/force_switch.hpp"

namespace forefeel {

class JetEstimates {
 public:
  // The space must outlive this.
  JetEstimates(const StateSpace& space, const ModelOptions& model, const SwitchOptions& jnd)
      : updater_(space, model), jnd_(jnd) {}

  double operator()(const Vec3& x);  // NaN while no state has a jet

 private:
  ModelUpdater updater_;
  Model model_;
  SwitchOptions jnd_;
};

}  // namespace forefeel
