#include "scheduling/workers/reference_service.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <fstream>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/workers/state_solver.hpp"
#include "solver/equilibrium/linear_body.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

Vec3 place_of(const State& state) {
  return state.has_site() ? state.site : Vec3::Zero();
}

}  // namespace

std::size_t ReferenceService::Hash::operator()(const Key& key) const {
  std::uint64_t hash = key.bits[0];
  for (int i = 1; i < 6; ++i) hash = random::mix(hash, key.bits[i]);
  return hash;
}

// -0 and 0 are one place.
ReferenceService::Key ReferenceService::key(const Vec3& x, const Vec3& site) {
  Key key;
  for (int i = 0; i < 3; ++i) {
    key.bits[i] = std::bit_cast<std::uint64_t>(x[i] + 0.0);
    key.bits[i + 3] = std::bit_cast<std::uint64_t>(site[i] + 0.0);
  }
  return key;
}

ReferenceService::ReferenceService(const ReferenceOptions& options, int threads)
    : solver_{.basis = std::make_shared<SolverBasis>(options.body),
              .linear = options.sites ? nullptr : linear_basis(options.body, options.spacing),
              .options = {.spacing = options.spacing,
                          .tolerance = 1e-6,
                          .displacements = options.displacements,
                          .jet = options.jet,
                          .sites = options.sites}},
      cache_(options, solver_.linear != nullptr),
      costs_([this] { return StateSolver(solver_.basis, solver_.linear, solver_.options); }, options,
             cache_.name()),
      threads_{.most = static_cast<std::size_t>(reference_threads(threads)), .running = {}} {
  for (State& state : cache_.take_states()) {
    const Key place = key(state.at, place_of(state));
    entries_.try_emplace(place, Entry{.ready = true, .state = std::move(state)});
  }
}

ReferenceService::~ReferenceService() {
  {
    const std::lock_guard lock(mutex_);
    queue_.clear();
  }
  for (auto& thread : threads_.running) thread.request_stop();
  wake_.notify_all();
  threads_.running.clear();
}

int reference_threads(int wanted) {
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return wanted > 0 ? std::min(wanted, std::max(8, 4 * cores)) : cores;
}

void ReferenceService::start_thread() {
  if (threads_.running.size() < threads_.most)
    threads_.running.emplace_back([this](const std::stop_token& stop) { work(stop); });
}

void ReferenceService::request(const Vec3& x, const SurfacePlace& site) {
  {
    const std::lock_guard lock(mutex_);
    if (!entries_.try_emplace(key(x, site.at)).second) return;
    queue_.push_back({x, site});
    start_thread();
  }
  wake_.notify_one();
}

State ReferenceService::get(const Vec3& x, const SurfacePlace& site) {
  return *get_until(x, std::chrono::steady_clock::time_point::max(), site);
}

std::optional<State> ReferenceService::get_until(const Vec3& x, std::chrono::steady_clock::time_point end,
                                                 const SurfacePlace& site) {
  request(x, site);
  std::unique_lock lock(mutex_);
  const Key wanted = key(x, site.at);
  const Entry& entry = entries_.at(wanted);  // stays valid while the map grows
  if (!entry.ready) {
    // A state that somebody waits for is moved to the front of the queue.
    const auto found =
        std::find_if(queue_.begin(), queue_.end(), [&](const Asked& q) { return key(q) == wanted; });
    if (found != queue_.end()) {
      queue_.erase(found);
      queue_.push_front({x, site});
    }
    const auto settled = [&] { return entry.ready || failure_; };
    if (end == std::chrono::steady_clock::time_point::max())
      ready_.wait(lock, settled);
    else if (!ready_.wait_until(lock, end, settled))
      return std::nullopt;
  }
  if (!entry.ready) std::rethrow_exception(failure_);
  return entry.state;
}

std::size_t ReferenceService::solved() const {
  const std::lock_guard lock(mutex_);
  return solved_;
}

void ReferenceService::take(const State& state) {
  Entry& entry = entries_[key(state.at, place_of(state))];
  if (entry.ready) return;
  entry = {.ready = true, .state = state};
  ready_.notify_all();
  wake_.notify_all();
}

std::optional<std::string> ReferenceService::cache_failure() {
  const std::lock_guard lock(mutex_);
  return cache_.failure();
}

void ReferenceService::work(std::stop_token stop) {
  try {
    StateSolver solver(solver_.basis, solver_.linear, solver_.options);
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [&] { return stop.stop_requested() || !queue_.empty(); });
      if (stop.stop_requested()) return;
      const Asked asked = queue_.front();
      queue_.pop_front();
      if (entries_.at(key(asked)).ready) continue;
      lock.unlock();
      SolveOutcome outcome = solver.reference(asked.x, asked.site);
      outcome.state.at = asked.x;
      if (asked.site.exists()) outcome.state.site = asked.site.at;
      outcome.state.solve.parent = Vec3::Zero();
      outcome.state.force.array() += 0.0;  // the cache does not keep -0
      outcome.state.stiffness.array() += 0.0;
      lock.lock();
      cache_.keep(outcome.state);
      take(outcome.state);
      ++solved_;
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
    ready_.notify_all();
  }
}

}  // namespace forefeel
