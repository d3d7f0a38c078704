#pragma once
// What summary.json holds, also for Python.

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "apps/scene/scene.hpp"
#include "apps/scene/scene_session.hpp"
#include "scheduling/motion/prediction_score.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {

struct MeshError;

// The summary with what a run alone does not know. mesh: ignored where the states are of another body.
SessionSummary whole_summary(const SessionResult& result, const SessionPlan& plan,
                             const PredictorScores& predictions, const SessionSummary::AwayFromStates& away,
                             const MeshError& mesh);

// summary.json without its shapes. field: of a body that may be touched anywhere.
nlohmann::ordered_json session_document(const SessionSummary& summary, const SessionResult& result,
                                        const Scene& scene, const std::optional<SessionField>& field);

}  // namespace forefeel
