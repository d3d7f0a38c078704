#pragma once
// Distributes pieces of work over all ranks (MPI processes) of a run. The calling thread of rank 0 gives each free rank
// its next piece and collects the results. A second thread of rank 0 solves pieces like the other ranks. If a rank is
// lost, its pieces are given out again.

#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "scheduling/workers/rank_pool.hpp"
#include "scheduling/workers/rank_server.hpp"

namespace forefeel {

// The work, as rank 0 sees it. Worker 0 is the thread of rank 0, worker r is rank r. Called by one thread.
class FarmWork {
 public:
  struct Piece {
    std::uint64_t id = 0;  // unique
    Bytes content = {};
  };
  virtual ~FarmWork() = default;
  // The next piece for that worker; nullopt: none is left, or none until another one is done.
  virtual std::optional<Piece> next(int worker) = 0;
  // Called once for each piece. Throws MalformedMessage for a result that cannot be read.
  virtual void done(std::uint64_t id, int worker, Unpacker result) = 0;
  virtual void again(std::uint64_t id) = 0;  // it was not done: next() must offer it again
  virtual void lost(int /*worker*/) {}       // that process is gone, with all data that it was sent
  virtual bool finished() const = 0;
  // True once after another thread has added pieces; else next() is only asked after a result or another event.
  virtual bool grew() { return false; }

  // Questions of the workers (RankContext::ask), and the answers found since the last call.
  struct Answer {
    int worker = 0;
    Bytes content = {};
  };
  virtual void asked(int /*worker*/, Unpacker /*question*/) {}  // may throw MalformedMessage
  virtual std::vector<Answer> answers() { return {}; }
};

struct FarmOptions {
  int queue = 1;                    // pieces that a rank has at a time; with 2 it never waits for the next
  std::stop_token stop = {};        // ends the farm; running pieces are dropped
  std::function<void()> tick = {};  // a few times in a second, and after each result
  std::function<void(const std::string&)> note = {};  // about lost ranks, when it happens
};

struct FarmReport {
  bool stopped = false;
  int ranks = 1;  // that took part, rank 0 included
  int lost = 0;   // of these, lost at the end
};

// Runs on rank 0, after pool.begin(). `own` makes the worker of rank 0's solving thread. At the end all ranks
// are told to stop. Throws what the solving thread throws; an exception in another rank loses that rank.
FarmReport run_farm(RankPool& pool, FarmWork& work, const LoadWorker& own, const FarmOptions& options);

}  // namespace forefeel
