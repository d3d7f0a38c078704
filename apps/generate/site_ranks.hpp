#pragma once
// States at sites, solved by all ranks of a run (scheduling/workers/farm.hpp). What is solved next depends on what came
// before, so a thread of its own decides and waits, while the farm gives out the places that it wants.

#include <functional>
#include <memory>
#include <span>

#include "apps/scene/field_check.hpp"
#include "scheduling/workers/farm.hpp"

namespace forefeel {

// Solves these; done(state, place number) is called by one thread at a time. Returns early when the run is stopped.
using SolvePlaces = std::function<void(std::span<const SitedPlace> places,
                                       const std::function<void(State, std::size_t)>& done)>;

// For rank 0, after pool.begin(): runs `work`, whose states the ranks solve. Throws what it throws. step [m]: of the
// solves.
FarmReport with_ranks(RankPool& pool, const std::shared_ptr<const RestSites>& sites, double step,
                      const FarmOptions& options, const std::function<void(const SolvePlaces&)>& work);

// For the other ranks.
std::unique_ptr<RankWorker> make_site_worker(std::shared_ptr<const RestSites> sites, double step);

}  // namespace forefeel
