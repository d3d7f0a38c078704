#include "scheduling/session/shaped_session.hpp"

#include "geometry/common/error.hpp"
#include "scheduling/session/one_run.hpp"
#include "scheduling/session/rehearsal.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/session/session_setup.hpp"

namespace forefeel {

SessionResult run_session(const SessionPlan& plan, const SessionHooks& hooks, ShapedRun* shapes) {
  if (!shapes) return run_session(plan, hooks);
  if (plan.input.touched.anywhere)
    throw InputError("session.shape_rate", "is of one place, expected 0 with contact.anywhere");
  if (plan.input.foreign)
    throw InputError("session.shape_rate", "needs states of the scene's own body, expected none of another");
  if (!plan.input.touched.displacements)
    throw InputError("session.shape_rate",
                     "needs states that hold displacements (state_space.displacements)");
  check_shapeable(plan.input.known, *plan.input.touched.body, "the known states");
  return is_rehearsed(plan) ? run_rehearsed(plan, hooks, shapes) : run_once(plan, hooks, shapes);
}

SessionResult run_session(const SessionPlan& plan, const SessionHooks& hooks) {
  return is_rehearsed(plan) ? run_rehearsed(plan, hooks) : run_once(plan, hooks);
}

SessionResult run_session(SessionInput input, SessionOptions options, const SessionHooks& hooks) {
  return run_session(make_plan(std::move(input), std::move(options)), hooks);
}

}  // namespace forefeel
