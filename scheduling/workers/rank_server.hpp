#pragma once
// Runs a rank above 0: loads the input when rank 0 asks for it, then solves job after job. One thread loads and solves.
// The calling thread exchanges messages and heartbeats, so a rank is not silent during a long solve.

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "scheduling/workers/transport.hpp"

namespace forefeel {

// Solves jobs, one at a time. Made and used by the solving thread.
class RankWorker {
 public:
  using Give =
      std::function<void(Bytes result)>;  // sends a result of the job at once; may be called many times
  virtual ~RankWorker() = default;
  // May throw: the rank then sends the reason to rank 0, and gets no more work.
  virtual void run(Unpacker job, const Give& give, const std::stop_token& cancelled) = 0;
};

// What a worker may use of its rank, from any thread.
struct RankContext {
  std::stop_token ended = {};  // the rank must end
  std::function<void(Bytes)> ask =
      {};  // sends a question to rank 0, which may answer at once, later or never
  // Sets the function that takes the answers; the thread that exchanges messages calls it. Null: answers are
  // dropped, and no call of the former function is running when listen() returns.
  std::function<void(std::function<void(Bytes)>)> listen = {};
  // The message that rank 0 sent when the work began (RankPool::begin()); waits for it. nullopt: the rank must end.
  std::function<std::optional<Bytes>()> begun = {};
};

// A worker, and what identifies its build and its input.
struct LoadedWorker {
  std::unique_ptr<RankWorker> worker;
  std::string identity;
};
using LoadWorker = std::function<LoadedWorker(const RankContext& context)>;

enum class ServedRank {
  done,      // rank 0 said stop
  busy,      // rank 0 said stop, but the solving thread does not stop: the process must end at once
  orphaned,  // rank 0 has been silent for orphaned_seconds
};
// Returns when the rank has nothing more to do. With `at_once`, loads before rank 0 says begin.
ServedRank serve_rank(Transport& transport, LoadWorker load, bool at_once = false);

}  // namespace forefeel
