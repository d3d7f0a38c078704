#pragma once
// Makes the models that the loop renders, and passes them to it (LoopLink).
//   ModelKeeper    from the states of a space, with their error bars (bar_keeper.hpp). It makes a new model when states
//                  have been added or the HIP has moved far enough, and reuses models that the loop returns
//   SurfaceMaker   of a body that is touched anywhere (touch/surface_models.hpp)

#include <cstdint>
#include <memory>
#include <vector>

#include "scheduling/common/records.hpp"
#include "scheduling/render/bar_keeper.hpp"
#include "scheduling/render/loop_link.hpp"
#include "scheduling/render/session_model.hpp"

namespace forefeel {

class ModelMaker {
 public:
  virtual ~ModelMaker() = default;
  virtual void update(double now, const Vec3& hip, bool time_it = false) = 0;
  virtual Label label() const { return Label::blank; }  // of the HIP when the newest model was made
  // When each state first entered a model [s], in the order in which they became known; NaN or missing: never.
  const std::vector<double>& first_used() const { return first_used_; }
  std::vector<SwitchRecord> take_switches() { return std::move(updates_); }  // one per published model

 protected:
  std::vector<double> first_used_;
  std::vector<SwitchRecord> updates_;
};

class ModelKeeper final : public ModelMaker {
 public:
  // The space and the link must outlive the keeper. One thread owns keeper and space.
  ModelKeeper(const StateSpace& space, const ModelRecipe& recipe, LoopLink& link);

  void update(double now, const Vec3& hip, bool time_it = false) override;
  Label label() const override { return last_.label; }

 private:
  class Pool {  // of models: in the loop, published, or free
   public:
    Model* take(LoopLink& link);  // null: the loop has not given one back yet
    void put(const Model* model) { free_.push_back(const_cast<Model*>(model)); }

   private:
    std::vector<std::unique_ptr<Model>> models_;
    std::vector<Model*> free_;
  };
  struct Update {  // the last one
    Vec3 at = Vec3::Zero();
    std::size_t states = 0;  // in the space then
    Label label = Label::blank;
  };
  struct Published {
    const Model* newest = nullptr;  // null: none yet
    std::uint32_t n = 0;            // its states
  };
  void publish(const Model* model, const SwitchRecord& record);

  const StateSpace& space_;
  LoopLink& link_;
  double travel_;  // that triggers an update [m]
  SessionModel updater_;
  BarKeeper bars_;
  Pool pool_;
  Update last_;
  Published published_;
};

}  // namespace forefeel
