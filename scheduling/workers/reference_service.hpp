#pragma once
// Solves states to a tight tolerance on the reference branch (the primary equilibrium path), by threads, and
// caches them on disk (reference_cache.hpp). A value depends on (body, x) alone: neither the number of threads nor the
// order of requests changes it.

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/generator.hpp"
#include "scheduling/workers/reference_cache.hpp"
#include "scheduling/workers/solve_costs.hpp"

namespace forefeel {

class LinearBasis;
class SolverBasis;

// Other processes that solve for the same body. Each position is solved by one of them. Any thread may call
// these.
class ReferenceExchange {
 public:
  virtual ~ReferenceExchange() = default;
  // May x be solved here? Answered by ReferenceService::grant(), put_off() or learn().
  virtual void ask(const Vec3& x) = 0;
  virtual void tell(const State& state) = 0;  // it was solved here
};

// Number of threads that solve, if `wanted` are asked for (0: all of the machine). At most the larger of eight and four
// for each core: more would only take memory.
int reference_threads(int wanted);

class ReferenceService {
 public:
  // threads: as reference_threads(). They start as requests come that are not in the cache.
  ReferenceService(const ReferenceOptions& options, int threads);
  ~ReferenceService();  // drops requests that have not begun
  ReferenceService(const ReferenceService&) = delete;
  ReferenceService& operator=(const ReferenceService&) = delete;

  // Any thread may call these at any time; x [m] is the position of the HIP.
  void request(const Vec3& x);  // queues x unless it is known; returns at once
  State get(const Vec3& x);     // waits for the state; rethrows a solving thread's exception
  std::optional<State> get_until(const Vec3& x,
                                 std::chrono::steady_clock::time_point end);  // nullopt: not ready in time
  std::size_t solved() const;  // number of solves not found in the cache
  // Adds states solved elsewhere, tight and on the reference branch. They are not written to the file.
  void learn(std::span<const State> states);
  // From now on the service asks the other processes about each position that is not in the cache, before it solves
  // it. Null ends this; positions without an answer are then solved here.
  void share(std::shared_ptr<ReferenceExchange> exchange);
  void grant(const Vec3& x);                       // solve it here
  void put_off(const Vec3& x);                     // it is solved elsewhere: learn() or grant() will follow
  void learn_and_keep(const State&);               // as learn(), and it is written to the cache
  std::optional<State> find(const Vec3& x) const;  // if it is ready

  // If a cache was requested but there is none, or it is read-only: the reason.
  const std::optional<std::string>& note() const { return costs_.note() ? costs_.note() : cache_.note(); }
  // Set if records of the cache had a wrong checksum: one line with file and count. They are solved again and
  // replaced.
  const std::optional<std::string>& damage() const { return cache_.damage(); }

  // Waits until the cache is on the disk. Returns one line if the cache could no longer be written (a full disk);
  // states solved after that are not kept.
  std::optional<std::string> cache_failure();

  // Times of a fixed sample of solves from a neighbour, and of the state at rest. They are measured once per
  // body and kept beside the cache.
  RecordedCosts recorded_costs() { return costs_.recorded(); }

 private:
  struct Key {
    std::uint64_t bits[3];
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct Hash {
    std::size_t operator()(const Key& key) const;
  };
  struct Entry {
    bool ready = false;
    State state;
  };
  // With other processes: permission for queued positions is asked a little before the threads need them.
  struct Sharing {
    std::shared_ptr<ReferenceExchange> exchange;
    std::deque<Vec3> granted;
    std::unordered_map<Key, Vec3, Hash> asked, put_off;
  };
  static Key key(const Vec3& x);
  void work(std::stop_token stop);
  void start_thread();              // unless there are enough
  void take(const State& state);    // under the mutex
  std::vector<Vec3> next_to_ask();  // under the mutex

  // Of which each thread makes its solver.
  struct SolverParts {
    std::shared_ptr<SolverBasis> basis;
    std::shared_ptr<LinearBasis> linear;
    StateSolverOptions options;
  };
  struct Threads {
    std::size_t most = 0;
    std::vector<std::jthread> running;
  };

  SolverParts solver_;

  mutable std::mutex mutex_;
  std::condition_variable wake_, ready_;
  ReferenceCache cache_;  // under the mutex
  SolveCosts costs_;
  std::unordered_map<Key, Entry, Hash> entries_;
  std::deque<Vec3> queue_;
  Sharing sharing_;
  std::size_t solved_ = 0;
  std::exception_ptr failure_;
  Threads threads_;
};

}  // namespace forefeel
