#pragma once
// Evaluates a run with exactly the states known in each frame:
//   label of every frame, with the states known in that frame
//   error at sampled frames against a tight solve on the reference branch, and its three parts:
//     error          |F - f|      F the rendered force, f the reference
//     approximation  |f~ - f|     f~ the force of the newest model
//     switch         |F - f~|
//     staleness      |f~ - f~*|   f~* the force of a model made from all states known at that moment
//   each over max(|f|, f0), f0 = error_floor
// Viscous body: in `error`, F and f are the forces after the relaxation filter (viscous_reference.hpp). The three parts
// compare elastic forces, before the filter.
// Samples are taken every reference_step of HIP travel, and in the first frame within each lattice cell. The
// judge is a stage that follows the run: it computes labels, samples and f~* frame by frame. finish() writes
// them to the result, waits for the references and adds the errors.

#include <memory>

#include "approx/switch/relaxation.hpp"
#include "approx/switch/switch_options.hpp"
#include "geometry/coverage/state_space.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/judge/frame_pipeline.hpp"
#include "scheduling/judge/judging_options.hpp"
#include "scheduling/render/session_model_options.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

struct JudgeSetup {
  ModelRecipe model = {};
  JudgingOptions judging = {};
  StopOptions stop = {};
  Viscosity viscosity = {};  // of the body
  SwitchOptions jnd = {};    // of the floor of error bars
  bool errors = true;        // false: labels alone; there is no body to compare with
};

// What the judges of both contacts share. Published models become switches when the loop takes them.
void keep_taken(SessionResult& result);
// Of `all` samples, how many have no error.
void note_missing(std::size_t failed, std::size_t late, std::size_t all, SessionResult& result);

class SessionJudge final : public FrameStage {
 public:
  // known: FramePipeline::known(). It and the references must outlive the judge.
  SessionJudge(const JudgeSetup& setup, const StateSpace& known, ReferenceService& references);
  ~SessionJudge() override;

  void frame(const PassedFrame& frame) override;
  // Call after all frames have passed. Adds labels and errors to the result, and replaces the published
  // models by the switches that the loop made.
  void finish(SessionResult& result, const ShowProgress& show);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
