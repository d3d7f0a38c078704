#pragma once
// Evaluates a run with exactly the states known in each frame:
//   label of every frame, with the states known in that frame
//   error at sampled frames against a tight solve on the reference branch, and its three parts:
//     error          |F - f|      F the rendered force, f the reference
//     approximation  |f~ - f|     f~ the force of the newest model
//     switch         |F - f~|
//     staleness      |f~ - f~*|   f~* the force of a model made from all states known at that moment
//   each over max(|f|, f0), f0 = error_floor
// Viscous body: in `error`, F and f are the forces after the relaxation filter (below). The three parts
// compare elastic forces, before the filter.
// Samples are taken every reference_step of HIP travel, and in the first frame within each lattice cell. The
// judge is a stage that follows the run: it computes labels, samples and f~* frame by frame. finish() writes
// them to the result, waits for the references and adds the errors.

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "approx/switch/relaxation.hpp"
#include "approx/switch/switch_options.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state.hpp"
#include "scheduling/common/records.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/judge/frame_pipeline.hpp"
#include "scheduling/judge/judging_options.hpp"
#include "scheduling/render/session_model_options.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

// The reference force of a viscous body in each frame of a run. Tight solves exist only at the samples, but the filter
// (approx/switch/relaxation.hpp) needs the elastic force f [N] in all frames. Between two samples a and b, f is
// interpolated by a cubic Hermite polynomial H of forces and stiffnesses along the chord. The offset d [m] of the HIP
// from the chord is taken into account by the interpolated stiffness:
//   f = H(s) - ((1 - s) K_a + s K_b) d,   H(0) = f_a, H(1) = f_b, H'(0) = -K_a (x_b - x_a), H'(1) = -K_b (x_b - x_a)
// s in [0, 1]: the share of the travel from a to b. Before the first sample and after the last one it is the tangent
// of that sample. Without stiffness: linear between forces. The error is of the fourth order in the distance of the
// samples (reference_step) along a straight path.

struct SampledState {
  std::size_t frame = 0;  // increasing
  State state = {};       // at the position of that frame, usable
};

// F of each frame [N]; empty if there are no samples.
std::vector<Vec3> viscous_reference(std::span<const FrameRecord> frames,
                                    std::span<const SampledState> samples, const Viscosity& viscosity);

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
