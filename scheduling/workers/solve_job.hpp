#pragma once
// One job of a session: its state first, then the states beside it, which reuse its factorisation.

#include <functional>
#include <stop_token>

#include "scheduling/workers/generator.hpp"
#include "scheduling/workers/state_solver.hpp"

namespace forefeel {

// Calls give() with each result as soon as it is ready; the caller sets JobResult::worker. now(): session time [s].
void solve_job(StateSolver& solver, const Job& job, const std::stop_token& stop,
               const std::function<double()>& now, const std::function<void(JobResult)>& give);

}  // namespace forefeel
