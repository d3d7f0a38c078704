#pragma once
// How far the model missed each state before it was known, in JNDs (PlannerView::surprises). One thread owns them.

#include <span>
#include <vector>

#include "approx/switch/force_switch.hpp"
#include "scheduling/render/session_model.hpp"

namespace forefeel {

class Surprises {
 public:
  // The space must outlive them.
  Surprises(const StateSpace& space, const ModelRecipe& model, const SwitchOptions& jnd)
      : space_(space), model_(space, model), jnd_(jnd) {}

  void note(const State& state);  // before it is inserted into the space
  std::span<const float> by_id() const { return errors_; }

 private:
  const StateSpace& space_;
  SessionModel model_;
  SwitchOptions jnd_;
  std::vector<float> errors_;
};

}  // namespace forefeel
