#pragma once
// The keys of a session's summary that scripts rely on; summary.json adds the error by label and the provenance.

#include "tests/support/test.hpp"

namespace forefeel {

inline const std::vector<std::string> session_summary_keys = [] {
  std::istringstream words(R"(
clock seconds frames deadline.missed deadline.cost_us.p50 deadline.cost_us.p99 deadline.cost_us.max
deadline.lateness_us.p50 deadline.lateness_us.p99 deadline.lateness_us.max states.start states.solved
states.used states.wasted states.preempted states.failed states.age_at_use_ms.p50
states.age_at_use_ms.p99 time_in.safe time_in.sparse time_in.gap time_in.blank switch.count switch.rule
switch.max_jump switch.max_jump_undamped switch.frames_over_jnd switch.drift.ms50 switch.drift.ms100
switch.drift.ms300 error.reference error.samples error.p50 error.p95 error.max error.within_jnd
error.parts.approximation error.parts.switch error.parts.staleness error.first_visit.p50
error.first_visit.p95 error.first_visit.within_jnd load energy.generated_J energy.work_J safety.clamped
safety.slewed safety.stale safety.non_finite workers policy select seed)");
  return std::vector<std::string>(std::istream_iterator<std::string>(words), {});
}();

}  // namespace forefeel
