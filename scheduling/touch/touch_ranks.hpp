#pragma once
// Workers of a touch session in other processes: worker w is rank w + 1 (scheduling/workers/rank_workers.hpp). A rank
// starts from its own solutions. What a lost rank was given comes back as cancelled.

#include <functional>
#include <memory>

#include "scheduling/touch/touch_workers.hpp"
#include "scheduling/workers/rank_pool.hpp"
#include "scheduling/workers/rank_server.hpp"

namespace forefeel {

// For rank 0. The pool must outlive the workers. now: session time [s].
std::unique_ptr<TouchWorkers> make_touch_ranks(RankPool& pool, std::function<double()> now);

// For the other ranks.
std::unique_ptr<RankWorker> make_touch_rank_worker(std::shared_ptr<const RestSites> sites, double step);

}  // namespace forefeel
