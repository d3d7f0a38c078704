#include "scheduling/study/study_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <map>
#include <mutex>
#include <thread>

#include "scheduling/motion/prediction_score.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/study/sustained_speed.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {
namespace {

constexpr std::size_t frames_between_predictions = 10;  // that are scored; next ones are nearly equal

// Equal for sessions with the same reference solves.
std::string body_key(const SessionInput& input) {
  std::string key =
      fmt::format("{} {} {}", input.touched.space.spacing, input.touched.displacements, input.touched.jet);
  for (const auto& [name, hash] : input.touched.identity) key += fmt::format(" {}={}", name, hash);
  return key;
}

// Share of all cells done; cells under way count in part.
class Ticker {
 public:
  Ticker(const std::function<void(const StudyProgress&)>& show, std::size_t cells, std::size_t resumed)
      : show_(show), parts_(cells, 0.0), resumed_(resumed) {}

  void at(std::size_t item, double part) {
    const std::lock_guard lock(mutex_);
    sum_ += part - parts_[item];
    parts_[item] = part;
    done_ += part >= 1 ? 1 : 0;
    if (show_)
      show_({.share = sum_ / static_cast<double>(parts_.size()),
             .done = done_,
             .cells = parts_.size(),
             .resumed = resumed_});
  }

 private:
  const std::function<void(const StudyProgress&)>& show_;
  std::mutex mutex_;
  std::vector<double> parts_;
  std::size_t done_ = 0, resumed_;
  double sum_ = 0;
};

// Share of a cell's work that its session has done.
double part_of(const SessionProgress& p) {
  const double share = p.seconds > 0 ? std::clamp(p.t / p.seconds, 0.0, 1.0) : 0.0;
  if (p.rehearsals > 0) return 0;
  if (p.phase == SessionPhase::session) return 0.6 * share;
  return p.phase == SessionPhase::labels ? 0.6 + 0.3 * share : 0.9 + 0.09 * share;
}

using ShowPart = std::function<void(double)>;
using Take = std::function<void(std::size_t cell, StudyCellResult row)>;

struct SessionFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws if the session failed: its result must not enter a study.
SessionResult unfailed(SessionResult result) {
  if (!result.failures.empty()) throw SessionFailed(result.failures.front());
  return result;
}

StudyCellResult run_plain(const StudyCell& cell, const SessionInput& input, const ShowPart& show) {
  const std::unique_ptr<Predictor> predictor =
      make_predictor(cell.options.motion.predictor, factory_context(input, cell.options.seed));
  PredictionScore score(*predictor, cell.options.clock.frame, score_horizons, frames_between_predictions);
  std::vector<Vec3> motion;
  const SessionResult result =
      unfailed(run_session(input, cell.options,
                           {.progress = [&](const SessionProgress& p) { show(part_of(p)); },
                            .each_position = [&](const Vec3& at) { motion.push_back(at); }}));
  // Scored afterwards: beside the session, a predictor in Python would wait for the session's at every frame.
  for (const Vec3& at : motion) score.add(at);
  StudyCellResult row = cell_result(result, input, cell.options);
  add_prediction(score.report(), row);
  row.set("motion_seconds", column_value(cell.motion_seconds));
  return row;
}

// The columns of a sustained cell are those of the session at the speed found, or at `low` if no speed holds.
StudyCellResult run_sustained(const SustainedOptions& sought, const StudyCell& cell,
                              const SessionInput& input, const ShowPart& show) {
  std::map<double, StudyCellResult> seen;
  const auto share_at = [&](double speed) {
    SessionOptions options = cell.options;
    options.motion.device = device_at_speed(cell.options.motion.device, speed, "study.sustained");
    options.clock.seconds = sought.travel / speed;
    const SessionResult result = unfailed(run_session(input, options));
    const double share = first_visits_within(result, options.switching, sought.tolerance);
    StudyCellResult row = cell_result(result, input, options);
    row.set("error.first_visit.within_7", column_value(share));
    seen[speed] = std::move(row);
    show(0.98 * (1 - std::exp(-0.15 * static_cast<double>(seen.size()))));
    return std::isfinite(share) ? share : 0.0;
  };
  const SustainedSpeed found = sustained_speed(sought, share_at);
  StudyCellResult row = found.speed > 0 ? seen.at(found.speed) : seen.begin()->second;
  row.set("sustained.speed", found.speed);
  row.set("sustained.capped", found.capped);
  row.set("sustained.trials", static_cast<std::uint64_t>(found.trials));
  return row;
}

bool raised(const std::atomic<bool>* flag) {
  return flag && flag->load(std::memory_order_relaxed);
}

// Runs cells of a plan one by one, from any thread. Cells of one body share their reference solves, as a cache file has
// one writer.
class CellRunner {
 public:
  CellRunner(const StudyPlan& plan, const StudyRunOptions& options, std::size_t threads)
      : plan_(plan), options_(options), threads_(static_cast<int>(threads)) {
    std::map<std::string, std::size_t> first;
    for (std::size_t i = 0; i < plan.inputs.size(); ++i)
      body_of_.push_back(first.try_emplace(body_key(plan.inputs[i]), i).first->second);
  }

  // show: the share done
  StudyCellResult run(std::size_t number, const ShowPart& show) {
    StudyCell cell = plan_.cells.at(number);
    cell.options.stop.interrupted = options_.interrupted;
    cell.options.stop.hurried = options_.hurried;
    SessionInput input = plan_.inputs[cell.input];
    input.references = references(body_of_[cell.input]);
    cell = with_load_found(cell, input);
    const std::optional<SustainedOptions>& sustained = plan_.study.sustained;
    return sustained ? run_sustained(*sustained, cell, input, show) : run_plain(cell, input, show);
  }

 private:
  std::shared_ptr<ReferenceService> references(std::size_t body) {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<ReferenceService>& service = services_[body];
    if (service) return service;
    service = std::make_shared<ReferenceService>(reference_options(plan_.inputs.at(body)), threads_);
    if (service->damage() && options_.warn) options_.warn(*service->damage());
    return service;
  }

  const StudyPlan& plan_;
  const StudyRunOptions& options_;
  int threads_;                       // of reference solves, for each body
  std::vector<std::size_t> body_of_;  // of each input: the first input with that body
  std::mutex mutex_;
  std::map<std::size_t, std::shared_ptr<ReferenceService>> services_;
};

// The threads that run the cells without a stored result.
class Pool {
 public:
  Pool(CellRunner& runner, const std::vector<std::size_t>& todo, std::size_t threads,
       const StudyRunOptions& options, Ticker& ticker, const Take& take)
      : runner_(runner), todo_(todo), options_(options), ticker_(ticker), take_(take) {
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < std::min(threads, todo_.size()); ++i) others.emplace_back([this] { work(); });
    work();
  }
  std::exception_ptr failed() const { return failed_; }
  // Cells whose session failed, and why the first did.
  std::size_t failed_cells() const { return failed_cells_; }
  std::size_t failed_cell() const { return failed_cell_; }
  const std::string& problem() const { return problem_; }

 private:
  void work() {
    for (std::size_t item = next_++; item < todo_.size() && !raised(options_.interrupted); item = next_++) {
      try {
        StudyCellResult row = runner_.run(todo_[item], [&](double part) { ticker_.at(item, part); });
        // An interrupted session may be incomplete, so its cell is dropped.
        if (raised(options_.interrupted)) break;
        take_(todo_[item], std::move(row));
        ticker_.at(item, 1.0);
      } catch (const SessionFailed& problem) {
        const std::lock_guard guard(failed_mutex_);
        if (failed_cells_++ == 0 || todo_[item] < failed_cell_) {
          failed_cell_ = todo_[item];
          problem_ = problem.what();
        }
      } catch (...) {
        const std::lock_guard guard(failed_mutex_);
        if (!failed_) failed_ = std::current_exception();
        next_ = todo_.size();
      }
    }
  }

  CellRunner& runner_;
  const std::vector<std::size_t>& todo_;
  const StudyRunOptions& options_;
  Ticker& ticker_;
  const Take& take_;
  std::atomic<std::size_t> next_{0};
  std::mutex failed_mutex_;
  std::exception_ptr failed_;
  std::size_t failed_cells_ = 0, failed_cell_ = 0;
  std::string problem_;
};

void throw_if_cells_failed(const Pool& pool, const StudyPlan& plan) {
  if (pool.failed_cells() == 0) return;
  const StudyCell& cell = plan.cells[pool.failed_cell()];
  const auto& own = plan.inputs[cell.input].parts.policy;
  const std::string_view policy = own ? own->name() : cell.options.planning.policy.name;
  throw StudyFailure(
      fmt::format("{} of {} cells failed, the first with policy {} and seed {}: {}; the results of the "
                  "others are kept, and "
                  "the same study runs the failed ones alone",
                  pool.failed_cells(), plan.cells.size(), policy, cell.seed, pool.problem()));
}

}  // namespace

StudyCell with_load_found(const StudyCell& cell, const SessionInput& input) {
  if (!(cell.load_to_find > 0)) return cell;
  constexpr int tries = 12;
  constexpr int corrected = 3;  // tries before bisecting between too much and too little
  constexpr double near = 0.025;
  StudyCell trial = cell, best = cell;
  trial.options.judging.reference_step =
      1e9;  // only the motion counts here: as few reference solves as can be
  trial.options.judging.visit_stride = 1'000'000;
  double demand = cell.free_demand, least = std::numeric_limits<double>::infinity();
  double too_little = 0, too_much = 0;  // demands
  for (int i = 0; i < tries && least > near; ++i) {
    const SessionResult result = unfailed(run_session(input, trial.options));
    const double load = summarise(result, input, trial.options).load;
    if (result.interrupted() || !std::isfinite(load)) break;
    const double met = load / cell.load_to_find;
    if (std::abs(std::log(met)) < least) {
      least = std::abs(std::log(met));
      best.options.workers.cost = trial.options.workers.cost;
    }
    (met < 1 ? too_little : too_much) = demand;
    demand = i + 1 < corrected || too_little == 0 || too_much == 0 ? demand * met
                                                                   : std::sqrt(too_little * too_much);
    trial.options.workers.cost = cost_for_load(cell.load_to_find, trial.options, demand);
  }
  return best;
}

std::optional<std::string> loads_missed(const StudyPlan& plan, const std::vector<StudyCellResult>& cells) {
  std::size_t missed = 0, of_hands = 0;
  double worst = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!(plan.cells[i].load_to_find > 0)) continue;
    ++of_hands;
    const double load = cells[i].number("load");
    const double miss = std::isfinite(load) ? std::abs(load / plan.cells[i].load_to_find - 1) : 1;
    missed += miss > 0.05 ? 1 : 0;
    worst = std::max(worst, miss);
  }
  if (missed == 0) return {};
  return fmt::format(
      "{} of {} cells with a hand miss their target_load by more than 5 %, by {:.0f} % at most: their "
      "sessions hold too few solves, expected a longer one; the column `load` holds what was met",
      missed, of_hands, 100 * worst);
}

StudyResult run_study(const StudyPlan& plan, const StudyRunOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  StudyResult result;
  result.cells.resize(plan.cells.size());
  std::vector<std::size_t> todo;
  for (std::size_t i = 0; i < plan.cells.size(); ++i) {
    auto row = options.store.load ? options.store.load(plan.cells[i]) : std::nullopt;
    if (row) {
      result.cells[i] = std::move(*row);
      ++result.resumed;
    } else if (options.part.has(i)) {
      todo.push_back(i);
    } else {
      ++result.of_other_parts;
    }
  }
  const unsigned machine = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t threads = options.threads > 0 ? static_cast<std::size_t>(options.threads) : machine;
  Ticker ticker(options.progress, todo.size(), result.resumed);
  std::atomic<std::size_t> done{0};
  const Take take = [&](std::size_t cell, StudyCellResult row) {
    if (options.store.save) options.store.save(plan.cells[cell], row);
    result.cells[cell] = std::move(row);
    ++done;
  };
  CellRunner runner(plan, options, threads);
  const Pool pool(runner, todo, threads, options, ticker, take);
  const bool interrupted = raised(options.interrupted);
  if (!interrupted && pool.failed()) std::rethrow_exception(pool.failed());
  if (!interrupted) throw_if_cells_failed(pool, plan);
  result.ran = done;
  result.interrupted = interrupted && result.ran < todo.size();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace forefeel
