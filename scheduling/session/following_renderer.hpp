#pragma once
// Renders a run whose motion does not depend on the force: a stage that follows the planner
// (judge/frame_pipeline.hpp), with the HIP and the states that were known in each frame. Planner and
// rendering then work side by side, and give the same bits as in turn.

#include <atomic>

#include "scheduling/judge/frame_pipeline.hpp"
#include "scheduling/render/model_keeper.hpp"
#include "scheduling/render/render_loop.hpp"

namespace forefeel {

class FollowingRenderer final : public FrameStage {
 public:
  // known: the pipeline's states; frames: at most so many come.
  FollowingRenderer(const StateSpace& known, const ModelRecipe& model, const RenderOptions& options,
                    std::size_t frames);

  void frame(const PassedFrame& frame) override;

  // After the run.
  ModelKeeper& models() { return models_; }
  RenderLoop& loop() { return loop_; }
  // Of a frame done lately; from any thread.
  double force() const { return force_.load(std::memory_order_relaxed); }  // |F| [N]
  Label label() const { return label_.load(std::memory_order_relaxed); }

 private:
  struct Motion final : Device {  // stands where the frame says
    Vec3 position(double, const Vec3&) noexcept override { return at; }
    double duration() const override;
    Vec3 at = Vec3::Zero();
  };
  LoopLink link_;
  Motion motion_;
  ModelKeeper models_;
  RenderLoop loop_;
  double frame_;  // [s]
  std::atomic<double> force_{0};
  std::atomic<Label> label_{Label::blank};
};

}  // namespace forefeel
