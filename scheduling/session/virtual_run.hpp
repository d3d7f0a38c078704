#pragma once
// Runs a session under the virtual clock: a discrete-event simulation of workers, planner and loop. Time is
// in whole nanoseconds. Events have a total order (time, kind, sequence): at one instant, results of workers
// come first, then arrivals, planning, and the frame.

#include <atomic>

#include "scheduling/judge/frame_pipeline.hpp"
#include "scheduling/render/model_keeper.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/session_setup.hpp"

namespace forefeel {

class InputLog;

// Renders a run whose motion does not depend on the force. It is a pipeline stage (judge/frame_pipeline.hpp) behind the
// planner, and gets the HIP and the known states of each frame. Planner and rendering run in parallel; the result is
// the same, bit by bit, as in sequence.
class FollowingRenderer final : public FrameStage {
 public:
  // known: FramePipeline::known(); frames: upper bound of their number; inputs: records what came in.
  FollowingRenderer(const StateSpace& known, const RunRendering& rendering, std::size_t frames,
                    InputLog* inputs = nullptr);

  void frame(const PassedFrame& frame) override;

  // Call these two after the run.
  ModelKeeper& models() { return models_; }
  RenderLoop& loop() { return loop_; }
  // Values of a recent frame; may be read from any thread.
  double force() const { return force_.load(std::memory_order_relaxed); }  // |F| [N]
  Label label() const { return label_.load(std::memory_order_relaxed); }

 private:
  struct Motion final : Device {  // at the position of the frame
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

struct VirtualParts {
  ReferenceService& references;  // gives the values of states
  FramePipeline& pipeline;       // receives the frames
  // A stage of the pipeline. Null if the motion depends on the force: the run then renders itself.
  FollowingRenderer* renderer;
  InputLog* inputs = nullptr;  // records what came in
};

// Fills the result, except for labels, errors and other values of the judge. If planning fails, the frames
// end there with the ramp at the end, and result.failures says why.
void run_virtual(const RunSetup& setup, const VirtualParts& parts, SessionResult& result,
                 const ShowProgress& show);

}  // namespace forefeel
