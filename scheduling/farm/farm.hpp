#pragma once
// Work in pieces, solved by all ranks of a run as they become free: by the other ranks, and by one thread of rank 0,
// whose calling thread gives out the pieces and takes their results as they come. The pieces of a rank that is lost
// are given out again.

#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "scheduling/farm/rank_pool.hpp"
#include "scheduling/farm/rank_server.hpp"

namespace forefeel {

// The work, as rank 0 sees it. Worker 0 is the thread of rank 0, worker r is rank r. Called by one thread.
class FarmWork {
 public:
  struct Piece {
    std::uint64_t id = 0;  // unique
    Bytes content = {};
  };
  virtual ~FarmWork() = default;
  // A piece for that worker; nullopt: there is none, or none before another is done.
  virtual std::optional<Piece> next(int worker) = 0;
  // MalformedMessage: the result has no meaning. Called once for each piece.
  virtual void done(std::uint64_t id, int worker, Unpacker result) = 0;
  virtual void again(std::uint64_t id) = 0;  // it was not done: next() must offer it again
  virtual void lost(int /*worker*/) {}       // what that process was sent before must be sent again
  virtual bool finished() const = 0;

  // Questions of hands (RankContext), and what has been found to say to them since the last call.
  struct Answer {
    int worker = 0;
    Bytes content = {};
  };
  virtual void asked(int /*worker*/, Unpacker /*question*/) {}  // may throw MalformedMessage
  virtual std::vector<Answer> answers() { return {}; }
};

struct FarmOptions {
  int queue = 1;                    // pieces that a rank holds; 2: it never waits for the next
  std::stop_token stop = {};        // ends the farm; running pieces are dropped
  std::function<void()> tick = {};  // a few times in a second, and after each result
  std::function<void(const std::string&)> note = {};  // about lost ranks, when it happens
};

struct FarmReport {
  bool stopped = false;
  int ranks = 1;  // that took part, rank 0 included
  int lost = 0;   // of them, and not back at the end
};

// Rank 0. `own` makes the hand of its own thread. The pool has begun; at the end its ranks are told to stop. Throws
// what the own thread throws; an exception in another rank loses that rank.
FarmReport run_farm(RankPool& pool, FarmWork& work, const LoadHand& own, const FarmOptions& options);

}  // namespace forefeel
