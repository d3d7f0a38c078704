#include "scheduling/session/session.hpp"

#include "scheduling/session/one_run.hpp"
#include "scheduling/session/rehearsal.hpp"
#include "scheduling/session/session_setup.hpp"

namespace forefeel {

SessionResult run_session(const SessionPlan& plan, const SessionHooks& hooks) {
  return is_rehearsed(plan) ? run_rehearsed(plan, hooks) : run_once(plan, hooks);
}

SessionResult run_session(SessionInput input, SessionOptions options, const SessionHooks& hooks) {
  return run_session(make_plan(std::move(input), std::move(options)), hooks);
}

}  // namespace forefeel
