#include "apps/session/session_document.hpp"

#include <nlohmann/json.hpp>
#include <span>

#include "apps/console/contact_json.hpp"
#include "apps/console/provenance.hpp"
#include "apps/console/summary_json.hpp"
#include "apps/scene/scene_contact.hpp"
#include "apps/scene/scene_mesh_error.hpp"
#include "apps/scene/scene_spacing.hpp"
#include "scheduling/record/summary_parts.hpp"

namespace forefeel {

SessionSummary whole_summary(const SessionResult& result, const SessionPlan& plan,
                             const PredictorScores& predictions, const SessionSummary::AwayFromStates& away,
                             const MeshError& mesh) {
  SessionSummary summary = summarise(result, plan);
  summary.motion.prediction = predictions.report();
  summary.motion.away = away;
  const MeshError found = plan.input.foreign ? MeshError{.why = "the states are of another body"} : mesh;
  summary.error.mesh = {found.error, found.positions, measured_by(found), found.low, found.high};
  return summary;
}

nlohmann::ordered_json session_document(const SessionSummary& summary, const SessionResult& result,
                                        const Scene& scene, const std::optional<SessionField>& field) {
  nlohmann::ordered_json document = to_json(summary);
  document["contact"] = document_of(contact_keys(), contact_note(scene));
  if (field) document["field"] = document_of(session_field_keys(), *field);
  if (scene.spacing.chosen) document["spacing_auto"] = to_json(*scene.spacing.chosen);
  document["prediction"] = to_json(std::span<const PredictorErrors>(summary.motion.prediction));
  document["provenance"] = provenance(scene.source.hash);
  if (const std::optional<Tolerance>& tolerance = scene.written.tolerance)
    document["tolerance"] =
        document_of(tolerance_keys(), ToleranceShown{tolerance_share(result, *tolerance), *tolerance});
  return document;
}

}  // namespace forefeel
