#pragma once
// After a session that touched a body anywhere, with exactly the states known in each frame:
//   label  of every frame in touch (geometry/coverage/sited_labels.hpp); jets at rest are states at x = 0
//   trust  by the states' own estimate (DeepStates::trusted); made anew where the tip has moved by a millimetre or a
//          new model came
//   bars   q_p times that estimate and what the switch holds back, at least a tenth of the JND; q_p quantiles of the
//          scores of the states that had come (DeepStates::scores) and of a prior
//   error  at sampled frames, |F - f| / max(|f|, f0), f of a tight solve at (s, x); of a viscous body before its filter
// Samples: every reference_step of the tip's way in touch, and the first frame in each cell of tip and site.

#include "scheduling/judge/session_judge.hpp"
#include "scheduling/touch/surface_models.hpp"

namespace forefeel {

// models: those that the session rendered. space: of the tip. threads: of labels and trust.
void judge_surface(const SurfaceModels& models, const JudgeSetup& setup, const StateSpaceOptions& space,
                   ReferenceService& references, int threads, SessionResult& result,
                   const ShowProgress& show);

}  // namespace forefeel
