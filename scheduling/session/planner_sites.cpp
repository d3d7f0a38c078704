// What a planner does otherwise where a body may be touched anywhere: states have a site, and jets at rest come first.

#include <limits>

#include "scheduling/session/planner.hpp"
#include "scheduling/touch/surface_models.hpp"

namespace forefeel {

// At the place of the tip.
State at_the_tip(const State& state) {
  State tip;
  tip.at = state.tip();
  tip.force = state.force;
  tip.stiffness = state.stiffness;
  tip.solve.status = state.solve.status;
  return tip;
}

// Two sites may share a place of the tip; both states count.
bool Planner::insert_at_site(const State& state, std::int64_t dispatch) {
  const State tip = at_the_tip(state);
  if (surprises_ && !state.at.isZero(0)) surprises_->note(state, tip.at);
  space_.insert(tip);
  setup_.surface->learn(state);
  log_.know(dispatch);
  const SurfaceMap& map = setup_.surface->task().field->rest().map();
  ranking_.candidates().learn({.at = tip.at, .site = {map.nearest(state.site).facet, state.site}});
  return true;
}

std::size_t Planner::dispatch_rests(double now) {
  std::size_t dispatched = 0;
  for (int worker = 0; worker < slots_.count(); ++worker) {
    if (!is_idle(worker)) continue;
    const std::optional<Candidate> rest = ranking_.candidates().take_rest();
    if (!rest) break;
    dispatch(worker, *rest, std::numeric_limits<double>::infinity(), {}, now).purpose = Purpose::rest;
    ++dispatched;
  }
  return dispatched;
}

}  // namespace forefeel
