#pragma once
// Judges a run, exactly and in the order in which states became known:
//   label of every frame, with the states known in that frame
//   error at sampled frames against a tight solve on the reference branch, and its three parts:
//     error          |F - f|      F the rendered force, f the reference
//     approximation  |f~ - f|     f~ the force of the newest model
//     switch         |F - f~|
//     staleness      |f~ - f~*|   f~* the force of a model made from all states known at that moment
//   each over max(|f|, f0), f0 = error_floor
// Samples are taken every reference_step of HIP travel, and in the first frame within each lattice cell.
// Labels, samples and f~* are worked out frame by frame as a stage that follows the run; finish() enters
// them, waits for the references and enters the errors.

#include <memory>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/judge/frame_pipeline.hpp"
#include "scheduling/judge/judging_options.hpp"
#include "scheduling/judge/stop_options.hpp"
#include "scheduling/log/session_result.hpp"
#include "scheduling/render/session_model_options.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

struct JudgeSetup {
  ModelRecipe model = {};
  JudgingOptions judging = {};
  StopOptions stop = {};
};

class SessionJudge final : public FrameStage {
 public:
  // known: the pipeline's. It and the references must outlive the judge.
  SessionJudge(const JudgeSetup& setup, const StateSpace& known, ReferenceService& references);
  ~SessionJudge() override;

  void frame(const PassedFrame& frame) override;
  // After all frames of the result have passed: enters labels and errors, and turns the models that were
  // published into the switches that the loop made of them.
  void finish(SessionResult& result, const ShowProgress& show);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
