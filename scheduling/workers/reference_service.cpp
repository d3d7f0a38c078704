#include "scheduling/workers/reference_service.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <fstream>

#include "geometry/common/csv_table.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/workers/state_solver.hpp"
#include "solver/equilibrium/linear_body.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

std::string cache_name(const BodyIdentity& identity, double spacing, bool displacements) {
  std::uint64_t low = 1, high = 2;
  const auto take = [&](const std::string& text) {
    for (const char c : text)
      low = random::mix(low, static_cast<unsigned char>(c)), high = random::mix(high, low);
    low = random::mix(low, 0x100);
  };
  for (const auto& [name, hash] : identity) take(name), take(hash);
  take(fmt::format("{}", spacing));
  take(solver_revision());
  return fmt::format("{:016x}{:016x}{}", low, high, displacements ? "-displacements" : "");
}

}  // namespace

std::size_t ReferenceService::Hash::operator()(const Key& key) const {
  return random::mix(random::mix(key.bits[0], key.bits[1]), key.bits[2]);
}

ReferenceService::Key ReferenceService::key(const Vec3& x) {
  Key key;
  for (int i = 0; i < 3; ++i)
    key.bits[i] = std::bit_cast<std::uint64_t>(x[i] + 0.0);  // -0 and 0 are one place
  return key;
}

ReferenceService::ReferenceService(const ReferenceOptions& options, int threads)
    : basis_(std::make_shared<SolverBasis>(options.body)),
      linear_(linear_basis(options.body, options.spacing)),
      solver_options_{.spacing = options.spacing, .tolerance = 1e-6, .displacements = options.displacements},
      box_(options.box),
      thread_count_(static_cast<std::size_t>(reference_threads(threads))) {
  if (options.cache_folder.empty() || options.identity.empty()) return;
  const std::string name = cache_name(options.identity, options.spacing, options.displacements);
  costs_file_ = options.cache_folder / (name + ".costs.csv");
  rest_cost_file_ = options.cache_folder / (name + ".rest-cost.csv");
  if (linear_) return;  // three solves cost less than a file
  const auto take = [&](const StateFile& file) {
    for (State& state : file.read_all()) {
      const Key place = key(state.at);
      entries_.try_emplace(place, Entry{.ready = true, .state = std::move(state)});
    }
    if (file.damaged() > 0)
      damage_ = damage_in_words((options.cache_folder / (name + ".states")).string(), file.damaged(), true);
  };
  const std::filesystem::path file = options.cache_folder / (name + ".states");
  try {
    if (options.read_only) throw InputError({.file = file.string()}, "another process of this run writes it");
    std::filesystem::create_directories(options.cache_folder);
    StateFileHeader header{
        .identity = options.identity, .spacing = options.spacing, .box = options.box, .notes = {}};
    header.notes["content"] = "tight solves on the reference branch";
    StateFile cache = StateFile::open_or_create(file, header);
    take(cache);
    cache.drop_damaged();
    writer_ = std::make_unique<StateWriter>(std::move(cache));
  } catch (const std::exception& problem) {
    entries_.clear();
    note_ = fmt::format("no cache of reference solves: {}", problem.what());
    try {  // another run writes the file; its states are used here, too
      const StateFile cache = StateFile::open_read_only(file);
      if (cache.header().identity != options.identity) return;
      take(cache);
      note_ = fmt::format("the cache of reference solves is only read: {}", problem.what());
    } catch (const std::exception&) {
      entries_.clear();
    }
  }
}

ReferenceService::~ReferenceService() {
  {
    const std::lock_guard lock(mutex_);
    queue_.clear();
    granted_.clear();
  }
  for (auto& thread : threads_) thread.request_stop();
  wake_.notify_all();
  threads_.clear();
}

int reference_threads(int wanted) {
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return wanted > 0 ? std::min(wanted, std::max(8, 4 * cores)) : cores;
}

void ReferenceService::start_thread() {
  if (threads_.size() < thread_count_)
    threads_.emplace_back([this](const std::stop_token& stop) { work(stop); });
}

void ReferenceService::request(const Vec3& x) {
  {
    const std::lock_guard lock(mutex_);
    if (!entries_.try_emplace(key(x)).second) return;
    queue_.push_back(x);
    start_thread();
  }
  wake_.notify_one();
}

State ReferenceService::get(const Vec3& x) {
  return *get_until(x, std::chrono::steady_clock::time_point::max());
}

std::optional<State> ReferenceService::get_until(const Vec3& x, std::chrono::steady_clock::time_point end) {
  request(x);
  std::unique_lock lock(mutex_);
  const Entry& entry = entries_.at(key(x));  // stays valid while the map grows
  if (!entry.ready) {
    // A state that somebody waits for is moved to the front of the queue.
    const Key wanted = key(x);
    const auto found =
        std::find_if(queue_.begin(), queue_.end(), [&](const Vec3& q) { return key(q) == wanted; });
    if (found != queue_.end()) {
      queue_.erase(found);
      queue_.push_front(x);
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
  const Key place = key(state.at);
  Entry& entry = entries_[place];
  asked_.erase(place);
  put_off_.erase(place);
  if (entry.ready) return;
  entry = {.ready = true, .state = state};
  ready_.notify_all();
  wake_.notify_all();
}

void ReferenceService::learn(std::span<const State> states) {
  const std::lock_guard lock(mutex_);
  for (const State& state : states) take(state);
}

void ReferenceService::learn_and_keep(const State& state) {
  const std::lock_guard lock(mutex_);
  if (const auto known = entries_.find(key(state.at)); known != entries_.end() && known->second.ready) return;
  keep(state);
  take(state);
}

std::optional<State> ReferenceService::find(const Vec3& x) const {
  const std::lock_guard lock(mutex_);
  const auto known = entries_.find(key(x));
  if (known == entries_.end() || !known->second.ready) return {};
  return known->second.state;
}

void ReferenceService::share(std::shared_ptr<ReferenceExchange> exchange) {
  const std::lock_guard lock(mutex_);
  exchange_ = std::move(exchange);
  if (exchange_) return;
  for (const Vec3& x : granted_) queue_.push_back(x);
  for (const auto* asked : {&asked_, &put_off_})
    for (const auto& [place, x] : *asked) queue_.push_back(x);
  granted_.clear();
  asked_.clear();
  put_off_.clear();
  for (std::size_t i = 0; i < queue_.size(); ++i) start_thread();
  wake_.notify_all();
}

void ReferenceService::grant(const Vec3& x) {
  const std::lock_guard lock(mutex_);
  const auto known = entries_.find(key(x));
  if (!exchange_ || known == entries_.end() || known->second.ready) return;
  asked_.erase(key(x));
  put_off_.erase(key(x));
  granted_.push_back(x);
  wake_.notify_one();
}

void ReferenceService::put_off(const Vec3& x) {
  const std::lock_guard lock(mutex_);
  if (asked_.erase(key(x)) > 0) put_off_.emplace(key(x), x);
  wake_.notify_one();
}

// One position more than there are threads is asked for, so that no thread waits for an answer.
std::vector<Vec3> ReferenceService::next_to_ask() {
  std::vector<Vec3> next;
  while (exchange_ && !queue_.empty() && asked_.size() + granted_.size() <= thread_count_) {
    const Vec3 x = queue_.front();
    queue_.pop_front();
    if (entries_.at(key(x)).ready) continue;
    asked_.emplace(key(x), x);
    next.push_back(x);
  }
  return next;
}

// The cache is optional: a session must not fail with its disk.
void ReferenceService::keep(const State& state) {
  if (!writer_) return;
  try {
    writer_->push(state);
    unflushed_ = true;
  } catch (const std::exception& problem) {
    note_cache_failure(problem);
  }
}

void ReferenceService::note_cache_failure(const std::exception& problem) {
  cache_failure_ = fmt::format("the cache of reference solves is no longer written: {}", problem.what());
  writer_.reset();
}

std::optional<std::string> ReferenceService::cache_failure() {
  const std::lock_guard lock(mutex_);
  if (writer_ && unflushed_) try {
      writer_->flush();
      unflushed_ = false;
    } catch (const std::exception& problem) {
      note_cache_failure(problem);
    }
  return cache_failure_;
}

void ReferenceService::work(std::stop_token stop) {
  try {
    StateSolver solver(basis_, linear_, solver_options_);
    std::unique_lock lock(mutex_);
    for (;;) {
      const std::vector<Vec3> asking = next_to_ask();
      if (const auto exchange = exchange_; exchange && !asking.empty()) {
        lock.unlock();
        for (const Vec3& x : asking) exchange->ask(x);
        lock.lock();
      }
      const auto may_ask = [&] { return asked_.size() + granted_.size() <= thread_count_; };
      wake_.wait(lock, [&] {
        return stop.stop_requested() || !granted_.empty() || (!queue_.empty() && (!exchange_ || may_ask()));
      });
      if (stop.stop_requested()) return;
      if (exchange_ && granted_.empty()) continue;
      std::deque<Vec3>& next = exchange_ ? granted_ : queue_;
      const Vec3 x = next.front();
      next.pop_front();
      if (entries_.at(key(x)).ready) continue;
      lock.unlock();
      SolveOutcome outcome = solver.reference(x);
      outcome.state.at = x;
      outcome.state.solve.parent = Vec3::Zero();
      outcome.state.force.array() += 0.0;  // the cache does not keep -0
      outcome.state.stiffness.array() += 0.0;
      lock.lock();
      keep(outcome.state);
      take(outcome.state);
      ++solved_;
      if (const auto exchange = exchange_) {
        lock.unlock();
        exchange->tell(outcome.state);
        lock.lock();
      }
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
    ready_.notify_all();
  }
}

// The lock is held while measuring, so that concurrent callers get the same list.
RecordedCosts ReferenceService::recorded_costs() {
  const std::lock_guard lock(costs_mutex_);
  if (!costs_.solves.empty()) return costs_;
  costs_.solves = kept(costs_file_, &ReferenceService::measured_costs);
  std::vector<double> rest = kept(rest_cost_file_, &ReferenceService::measured_rest_costs);
  std::ranges::sort(rest);
  costs_.rest = rest.empty() ? 1e-9 : rest[rest.size() / 2];
  return costs_;
}

std::vector<double> ReferenceService::measured_costs() {
  constexpr std::uint64_t samples = 48;
  StateSolver solver(basis_, linear_, solver_options_);
  std::vector<double> seconds;
  for (std::uint64_t i = 0; i < samples; ++i) {
    const Vec3 share(random::uniform(random::mix(11, 3 * i)), random::uniform(random::mix(11, 3 * i + 1)),
                     random::uniform(random::mix(11, 3 * i + 2)));
    const Vec3 x = box_.low + share.cwiseProduct(box_.size());
    const double length = std::max(x.norm(), 1e-12);
    const Vec3 parent = x * std::max(0.0, 1 - solver_options_.spacing / length);  // a spacing nearer to rest
    const SolveOutcome start = solver.reference(parent);
    const auto before = std::chrono::steady_clock::now();
    const SolveOutcome outcome = solver.from(start.equilibrium.get(), x, {});
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
    if (outcome.state.usable()) seconds.push_back(std::max(took.count(), 1e-9));
  }
  return seconds;
}

// Measured between solves at other positions, as in a session. The first solve is not counted: it includes
// the symbolic factorisation.
std::vector<double> ReferenceService::measured_rest_costs() {
  constexpr int samples = 15;
  StateSolver solver(basis_, linear_, solver_options_);
  std::vector<double> seconds;
  for (int i = 0; i < samples; ++i) {
    solver.from(nullptr, solver_options_.spacing * Vec3::Unit(i % 3), {});
    const auto before = std::chrono::steady_clock::now();
    const SolveOutcome outcome = solver.from(nullptr, Vec3::Zero(), {});
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
    if (outcome.state.usable()) seconds.push_back(std::max(took.count(), 1e-9));
  }
  return seconds;
}

std::vector<double> ReferenceService::kept(const std::filesystem::path& file,
                                           std::vector<double> (ReferenceService::*measured)()) {
  constexpr std::string_view columns[] = {"seconds"};
  if (!file.empty() && std::filesystem::exists(file)) try {
      if (std::vector<double> values = read_csv(file, columns).values; !values.empty()) return values;
    } catch (const InputError&) {  // damaged: measured again
    }
  std::vector<double> seconds = (this->*measured)();
  if (file.empty() || seconds.empty()) return seconds;
  try {
    std::filesystem::create_directories(file.parent_path());
    OutputFile out(file);
    out.write("seconds\n");
    for (const double s : seconds) out.write(fmt::format("{}\n", s));
    out.commit();
  } catch (const std::exception& problem) {
    note_ = fmt::format("recorded costs are not kept: {}", problem.what());
  }
  return seconds;
}

}  // namespace forefeel
