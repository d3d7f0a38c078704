#pragma once
// Makes shapes under the virtual clock: a stage of the frame pipeline (judge/frame_pipeline.hpp) that takes a shape at
// the first frame at or after each instant k / rate. Repeated runs give the same bytes.

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
  // One line if it failed; it makes no shapes after that.
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
