#pragma once
// Solves states to a tight tolerance on the reference branch (the primary equilibrium path), by threads, and
// caches them on disk (reference_cache.hpp). A value depends on body, x and site alone: neither the number of threads
// nor the order of requests changes it.

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
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

  // Any thread may call these at any time; x [m] is the position of the HIP, from its site where the body is touched
  // anywhere.
  void request(const Vec3& x, const SurfacePlace& site = {});  // queues x unless it is known; returns at once
  // Waits for the state; rethrows a solving thread's exception.
  State get(const Vec3& x, const SurfacePlace& site = {});
  // nullopt: not ready in time.
  std::optional<State> get_until(const Vec3& x, std::chrono::steady_clock::time_point end,
                                 const SurfacePlace& site = {});
  std::size_t solved() const;  // number of solves not found in the cache
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
    std::uint64_t bits[6];  // of x and of the site's place
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct Hash {
    std::size_t operator()(const Key& key) const;
  };
  struct Entry {
    bool ready = false;
    State state;
  };
  struct Asked {
    Vec3 x;
    SurfacePlace site;
  };
  static Key key(const Vec3& x, const Vec3& site);
  static Key key(const Asked& asked) { return key(asked.x, asked.site.at); }
  void work(std::stop_token stop);
  void start_thread();            // unless there are enough
  void take(const State& state);  // under the mutex

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
  std::deque<Asked> queue_;
  std::size_t solved_ = 0;
  std::exception_ptr failure_;
  Threads threads_;
};

}  // namespace forefeel
