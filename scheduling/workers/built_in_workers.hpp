#pragma once
// The built-in kinds of workers.

#include <memory>

namespace forefeel {

class RealWorkers;
class VirtualWorkers;
struct RealWorkersContext;
struct VirtualWorkersContext;

std::unique_ptr<RealWorkers> make_worker_threads(RealWorkersContext& context);  // worker_threads.cpp
std::unique_ptr<VirtualWorkers> make_simulated_workers(
    VirtualWorkersContext& context);  // simulated_workers.cpp

}  // namespace forefeel
