#pragma once
// Shapes under the virtual clock: a stage that follows the run (judge/frame_pipeline.hpp) and takes a shape at
// the first frame of each instant k / rate. The same bytes each time.

#include <optional>
#include <string>

#include "scheduling/judge/frame_pipeline.hpp"
#include "scheduling/shape/shape_log.hpp"

namespace forefeel {

class ShapeStage final : public FrameStage {
 public:
  // known: FramePipeline::known(); frame: time of a frame [s]. Log and space must outlive the stage.
  ShapeStage(ShapeLog& log, const StateSpace& known, double frame);
  void frame(const PassedFrame& frame) override;
  // One line if it failed, since when it made no shapes.
  const std::optional<std::string>& failure() const { return failure_; }

 private:
  void follow(const PassedFrame& frame);

  ShapeLog& log_;
  const StateSpace& known_;
  double frame_;
  std::size_t taken_ = 0;
  std::optional<std::string> failure_;
};

}  // namespace forefeel
