#pragma once
// One run of a planned session, without rehearsals: the run by its clock, then its judgement.

#include "scheduling/session/session_hooks.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {

// The plan's service of reference solves, or one of its own.
std::shared_ptr<ReferenceService> references_of(const SessionPlan& plan);

// Whether rest is to be known from the start and is not among the known states yet: run_once() adds it as the
// last one.
bool adds_rest(const SessionPlan& plan);

SessionResult run_once(const SessionPlan& plan, const SessionHooks& hooks);

}  // namespace forefeel
