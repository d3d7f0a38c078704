#include "scheduling/session/rehearsal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "scheduling/session/one_run.hpp"
#include "scheduling/session/run_parts.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

std::vector<std::string> schedules_to_rehearse() {
  std::vector<std::string> names = policy_names();
  std::erase_if(names, [](const std::string& name) {
    return name == "clairvoyant" || name.find("shuffled") != std::string::npos;
  });
  std::stable_partition(names.begin(), names.end(),
                        [](const std::string& name) { return name == "clairvoyant-greedy"; });
  return names;
}

namespace {

// Share of first visits within the JND; negative if there are no first visits.
double first_visits_within(const SessionResult& result, const SwitchOptions& jnd) {
  std::size_t visits = 0, within = 0;
  for (const FrameRecord& f : result.frames) {
    if (!f.judged.first_visit || !std::isfinite(f.judged.error)) continue;
    ++visits;
    within += (compared_force(f) - f.judged.reference).norm() <=
              std::max(jnd.jnd_share * f.judged.reference.norm(), jnd.jnd_floor);
  }
  return visits > 0 ? static_cast<double>(within) / static_cast<double>(visits) : -1.0;
}

ShowProgress as_rehearsal(const ShowProgress& show, std::size_t which, std::size_t of) {
  if (!show) return {};
  return [&show, which, of](SessionProgress progress) {
    progress.rehearsal = which;
    progress.rehearsals = of;
    show(progress);
  };
}

// The result of a session that was interrupted during a rehearsal: no frames and no solves.
// with_rest: its first states end with one at rest that the plan does not hold.
SessionResult not_begun(SessionResult tried, bool with_rest, std::string note) {
  SessionResult result;
  tried.states.resize(tried.counts.start - (with_rest ? 1 : 0));
  result.states = std::move(tried.states);
  result.counts.start = result.states.size();
  result.run.end = RunEnd::not_begun;
  result.notes.push_back(std::move(note));
  return result;
}

struct Rehearsals {
  std::string best;
  std::size_t tried = 0, of = 0;     // schedules
  std::optional<SessionResult> cut;  // of the rehearsal that was interrupted
};

Rehearsals rehearse(const SessionPlan& plan, const ShowProgress& show) {
  const std::vector<std::string> schedules = schedules_to_rehearse();
  Rehearsals found{.best = schedules.front(), .of = schedules.size(), .cut = {}};
  double most = -2;
  for (; found.tried < schedules.size() && most < 1; ++found.tried) {  // a share of 1 cannot be exceeded
    const std::string& name = schedules[found.tried];
    SessionResult result = run_once(with_policy(plan, name),
                                    {.progress = as_rehearsal(show, found.tried + 1, schedules.size())});
    if (plan.options.stop.is_interrupted()) {
      found.cut = std::move(result);
      return found;
    }
    if (!result.failures.empty()) throw std::runtime_error(result.failures.front());
    const double share = first_visits_within(result, plan.options.switching);
    if (share > most) {
      most = share;
      found.best = name;
    }
  }
  return found;
}

}  // namespace

SessionResult run_rehearsed(SessionPlan plan, const SessionHooks& hooks, ShapedRun* shapes) {
  const auto start = std::chrono::steady_clock::now();
  const bool own = !plan.input.references;
  plan.input.references = references_of(plan.input, plan.options.workers);  // one for all rehearsals
  const auto state_file = std::exchange(plan.input.files.states, std::nullopt);
  const auto inputs_file = std::exchange(plan.input.files.inputs, std::nullopt);
  Rehearsals rehearsed = rehearse(plan, hooks.progress);
  plan.input.files.states = state_file;
  plan.input.files.inputs = inputs_file;
  if (rehearsed.cut) {
    open_state_file(state_file, states_header(plan.input.touched));
    SessionResult result = not_begun(
        std::move(*rehearsed.cut), adds_rest(plan.input, plan.options),
        fmt::format("interrupted while simulating schedule {} of {}: the session itself was not begun",
                    rehearsed.tried + 1, rehearsed.of));
    if (hooks.when_run) hooks.when_run(result);
    result.run.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
  }
  const std::shared_ptr<ReferenceService> references = plan.input.references;
  SessionResult result = run_once(with_policy(std::move(plan), rehearsed.best), hooks, shapes);
  if (own && references->damage()) result.warnings.push_back(*references->damage());
  result.notes.push_back(fmt::format(
      "clairvoyant: {} was the best of {} schedules that were simulated{}", rehearsed.best, rehearsed.tried,
      rehearsed.tried < rehearsed.of ? ": all first visits are within the JND, none can be better" : ""));
  return result;
}

}  // namespace forefeel
