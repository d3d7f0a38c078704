#pragma once
// Makes the models that the loop renders, from the states of a space, and their error bars (bar_keeper.hpp). It makes a
// new model when states have been added or the HIP has moved far enough, passes it to the render loop (LoopLink), and
// reuses models that the loop returns.

#include <cstdint>
#include <memory>
#include <vector>

#include "scheduling/common/records.hpp"
#include "scheduling/render/bar_keeper.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/render/session_model.hpp"

namespace forefeel {

class ModelKeeper {
 public:
  // The space and the link must outlive the keeper. One thread owns keeper and space.
  ModelKeeper(const StateSpace& space, const ModelRecipe& recipe, LoopLink& link);

  void update(double now, const Vec3& hip, bool time_it = false);
  Label label() const { return label_; }  // of the HIP when the newest model was made
  // When each state first entered a model [s], by id; NaN or missing: never.
  const std::vector<double>& first_used() const { return first_used_; }
  std::vector<SwitchRecord> take_switches() { return std::move(updates_); }  // one per published model

 private:
  Model* free_model();

  const StateSpace& space_;
  LoopLink& link_;
  double travel_;  // that triggers an update [m]
  SessionModel updater_;
  std::vector<std::unique_ptr<Model>> models_;
  std::vector<Model*> free_;
  const Model* newest_ = nullptr;  // published
  BarKeeper bars_;
  bool published_ = false;  // a model
  Vec3 updated_at_ = Vec3::Zero();
  std::size_t updated_states_ = 0;  // in the space then
  std::uint32_t updated_n_ = 0;
  Label label_ = Label::blank;
  std::vector<double> first_used_;
  std::vector<SwitchRecord> updates_;
};

}  // namespace forefeel
