#include "apps/study/study_run.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/console/console.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/picture/summary_json.hpp"
#include "apps/study/study_speed.hpp"
#include "geometry/common/output_file.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

// ---- columns
// -------------------------------------------------------------------------------------------------------

bool depends_on_wall_time(const std::string& path) {
  return path.starts_with("deadline.cost_us") || path.starts_with("deadline.lateness_us") ||
         path == "wall_seconds" || path == "realtime_priority" || path == "memory_locked";
}

double quantile95(std::vector<double> values) {
  if (values.empty()) return unknown;
  std::ranges::sort(values);
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

void add_first_visits(const SessionResult& result, const SwitchOptions& jnd, double tolerance,
                      CellColumns& columns) {
  const std::pair<const char*, double Judgement::*> parts[] = {{"approximation", &Judgement::approximation},
                                                               {"switch", &Judgement::switching},
                                                               {"staleness", &Judgement::staleness}};
  for (const auto& [name, member] : parts) {
    std::vector<double> values;
    for (const FrameRecord& frame : result.frames)
      if (frame.judged.first_visit && std::isfinite(frame.judged.*member))
        values.push_back(frame.judged.*member);
    columns[fmt::format("error.first_visit.parts.{}", name)] = number(quantile95(std::move(values)));
  }
  std::size_t visits = 0, within = 0;
  for (const FrameRecord& frame : result.frames) {
    if (!frame.judged.first_visit || !frame.judged.reference.allFinite()) continue;
    ++visits;
    within += (frame.force - frame.judged.reference).norm() <=
                      std::max(tolerance * frame.judged.reference.norm(), jnd.jnd_floor)
                  ? 1
                  : 0;
  }
  columns["error.first_visit.within_7"] =
      number(visits > 0 ? static_cast<double>(within) / static_cast<double>(visits) : unknown);
}

// What still runs at the end counts as busy, not as wasted.
void add_solver_time(const SessionResult& result, double end, CellColumns& columns) {
  double busy = 0, preempted = 0, wasted = 0;
  std::size_t solved = 0, used = 0;
  for (const DispatchRecord& job : result.dispatch) {
    if (!std::isfinite(job.started) || job.status == DispatchStatus::arrived) continue;
    const double seconds =
        std::max(0.0, std::min(std::isfinite(job.finished) ? job.finished : end, end) - job.started);
    busy += seconds;
    if (job.status == DispatchStatus::preempted) preempted += seconds;
    if (job.status != DispatchStatus::solved) continue;
    ++solved;
    used += std::isfinite(job.first_used) ? 1 : 0;
    wasted += std::isfinite(job.first_used) ? 0 : seconds;
  }
  columns["states.used_share"] =
      number(solved > 0 ? static_cast<double>(used) / static_cast<double>(solved) : unknown);
  columns["solver.busy"] = busy;
  columns["solver.preempted"] = preempted;
  columns["solver.wasted"] = wasted;
}

// ---- the store
// -----------------------------------------------------------------------------------------------------

fs::path record_file(const fs::path& folder, const StudyCell& cell) {
  return folder / "cells" / (cell.key + ".json");
}

std::optional<CellColumns> read_record(const fs::path& folder, const StudyCell& cell) {
  std::ifstream in(record_file(folder, cell));
  if (!in) return {};
  const auto record = nlohmann::ordered_json::parse(in, nullptr, false);
  if (!record.is_object() || !record.contains("columns") || record.value("key", "") != cell.key) return {};
  return record.at("columns");
}

void write_record(const fs::path& folder, const StudyCell& cell, const CellColumns& columns) {
  nlohmann::ordered_json record{
      {"key", cell.key}, {"device", cell.options.motion.device}, {"cost", cell.options.workers.cost}};
  record["columns"] = columns;
  OutputFile out(record_file(folder, cell));
  out.write(record.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  out.commit();
}

class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder) {
    descriptor_ = open((folder / "cells" / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
    if (descriptor_ < 0)
      throw InputError({.file = folder.string()}, "cannot be written, expected a folder for the results");
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      close(descriptor_);
      throw InputError({.file = folder.string()},
                       "another study is writing here, expected a folder of its own");
    }
  }
  ~FolderLock() { close(descriptor_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

// ---- running
// -------------------------------------------------------------------------------------------------------

// One service of reference solves for each body, spacing and kind of state, as the cache keeps them apart.
class References {
 public:
  References(const Globals& globals, int threads) : globals_(globals), threads_(threads) {}
  std::shared_ptr<ReferenceService> of(const SessionInput& input) {
    std::string key = fmt::format("{} {}", input.touched.space.spacing, input.touched.displacements);
    for (const auto& [name, hash] : input.touched.identity) key += fmt::format(" {}={}", name, hash);
    const std::lock_guard lock(mutex_);
    std::shared_ptr<ReferenceService>& service = services_[key];
    if (service) return service;
    service = std::make_shared<ReferenceService>(reference_options(input), threads_);
    if (service->damage()) warn(globals_, *service->damage());
    return service;
  }

 private:
  const Globals& globals_;
  int threads_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<ReferenceService>> services_;
};

// Share of all cells done, those under way counted in part; shown by whoever gets on.
class Ticker {
 public:
  Ticker(const Globals& globals, std::size_t todo, std::size_t resumed)
      : progress_(globals, "study"), parts_(todo, 0.0), resumed_(resumed) {}
  void at(std::size_t item, double part) {
    const std::lock_guard lock(mutex_);
    sum_ += part - parts_[item];
    parts_[item] = part;
    done_ += part >= 1 ? 1 : 0;
    progress_.show(sum_ / static_cast<double>(parts_.size()),
                   fmt::format("{} of {} cells{}", done_, parts_.size(),
                               resumed_ > 0 ? fmt::format(" ({} there before)", resumed_) : ""));
  }

 private:
  std::mutex mutex_;
  Progress progress_;
  std::vector<double> parts_;
  std::size_t done_ = 0, resumed_;
  double sum_ = 0;
};

double part_of(const SessionProgress& p) {
  const double share = p.seconds > 0 ? std::clamp(p.t / p.seconds, 0.0, 1.0) : 0.0;
  if (p.rehearsals > 0) return 0;
  if (p.phase == SessionPhase::session) return 0.6 * share;
  return p.phase == SessionPhase::labels ? 0.6 + 0.3 * share : 0.9 + 0.09 * share;
}

CellColumns run_plain(const StudyPlan& plan, const StudyCell& cell, const SessionInput& input,
                      const std::function<void(double)>& show) {
  const SessionResult result =
      run_cell(plan, cell, input, [&](const SessionProgress& p) { show(part_of(p)); });
  return cell_columns(result, input, cell.options);
}

// The columns of a sustained cell are those of the session at the speed found, or at `low` where none holds.
CellColumns run_sustained(const StudyPlan& plan, const StudyCell& cell, const SessionInput& input,
                          const std::function<void(double)>& show) {
  const SustainedOptions& sought = *plan.study.sustained;
  std::map<double, CellColumns> seen;
  const auto share_at = [&](double speed) {
    StudyCell trial = cell;
    trial.options.motion.device =
        device_at_speed(cell.options.motion.device, speed, plan.study.sustained_place);
    trial.options.clock.seconds = sought.travel / speed;
    const SessionResult result = run_cell(plan, trial, input, {});
    CellColumns columns = cell_columns(result, input, trial.options);
    add_first_visits(result, trial.options.switching, sought.tolerance, columns);
    const auto share = columns["error.first_visit.within_7"];
    seen[speed] = std::move(columns);
    show(0.98 * (1 - std::exp(-0.15 * static_cast<double>(seen.size()))));
    return share.is_number() ? share.get<double>() : 0.0;
  };
  const SustainedSpeed found = sustained_speed(sought, share_at);
  CellColumns columns = found.speed > 0 ? seen.at(found.speed) : seen.begin()->second;
  columns["sustained.speed"] = found.speed;
  columns["sustained.capped"] = found.capped;
  columns["sustained.trials"] = found.trials;
  return columns;
}

}  // namespace

CellColumns cell_columns(const SessionResult& result, const SessionInput& input,
                         const SessionOptions& options) {
  CellColumns columns = CellColumns::object();
  for (const Column& column : summary_columns(summarise(result, input, options)))
    columns[column.name] =
        depends_on_wall_time(column.name) ? nlohmann::ordered_json(nullptr) : to_json(column.value);
  add_first_visits(result, options.switching, 0.07, columns);
  add_solver_time(result, options.clock.seconds, columns);
  columns["cost"] = options.workers.cost;
  return columns;
}

SessionResult run_cell(const StudyPlan& plan, const StudyCell& cell, const SessionInput& input,
                       const std::function<void(const SessionProgress&)>& progress) {
  try {
    return run_session(input, cell.options, progress);
  } catch (const InputError& error) {
    throw located(plan.study, error);
  }
}

StudyCell with_load_found(const StudyPlan& plan, const StudyCell& cell, const SessionInput& input) {
  if (!(cell.load_to_find > 0)) return cell;
  constexpr int tries = 12,
                corrected = 3;  // from then on halfway between what is too much and what is too little
  constexpr double near = 0.025;
  StudyCell trial = cell, best = cell;
  trial.options.judging.reference_step = 1e9;  // what is rehearsed is the motion alone
  trial.options.judging.visit_stride = 1'000'000;
  double demand = cell.free_demand, least = std::numeric_limits<double>::infinity();
  double too_little = 0, too_much = 0;  // demands
  for (int i = 0; i < tries && least > near; ++i) {
    const SessionResult result = run_cell(plan, trial, input, {});
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
    trial.options.workers.cost =
        cost_for_load(cell.load_to_find, trial.options, demand, plan.study.origin.at("target_load"));
  }
  return best;
}

std::optional<std::string> loads_missed(const StudyPlan& plan, const std::vector<CellColumns>& cells) {
  std::size_t missed = 0, of_hands = 0;
  double worst = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!(plan.cells[i].load_to_find > 0)) continue;
    ++of_hands;
    const auto load = cells[i].find("load");
    const double miss = load != cells[i].end() && load->is_number()
                            ? std::abs(load->get<double>() / plan.cells[i].load_to_find - 1)
                            : 1;
    missed += miss > 0.05 ? 1 : 0;
    worst = std::max(worst, miss);
  }
  if (missed == 0) return {};
  return fmt::format(
      "{} of {} cells with a hand miss their target_load by more than 5 %, by {:.0f} % at most: their "
      "sessions hold too few "
      "solves, expected a longer one; the column `load` holds what was met",
      missed, of_hands, 100 * worst);
}

StudyResult run_study(const StudyPlan& plan, const fs::path& folder, const Globals& globals) {
  std::error_code error;
  fs::create_directories(folder / "cells", error);
  const FolderLock lock(folder);
  const auto start = std::chrono::steady_clock::now();
  StudyResult result;
  result.cells.resize(plan.cells.size());
  std::vector<std::size_t> todo;
  for (std::size_t i = 0; i < plan.cells.size(); ++i) {
    if (auto columns = read_record(folder, plan.cells[i]))
      result.cells[i] = std::move(*columns);
    else
      todo.push_back(i);
  }
  result.ran = todo.size();
  result.resumed = plan.cells.size() - todo.size();

  const unsigned machine = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t threads = globals.threads > 0 ? static_cast<std::size_t>(globals.threads) : machine;
  References references(globals, static_cast<int>(threads));
  Ticker ticker(globals, todo.size(), result.resumed);
  std::atomic<std::size_t> next{0};
  std::atomic<std::size_t> done{0};
  std::mutex failed_mutex;
  std::exception_ptr failed;
  const InterruptWatch watch;
  const auto work = [&] {
    for (std::size_t item = next++; item < todo.size() && !watch.raised(); item = next++) {
      try {
        StudyCell cell = plan.cells[todo[item]];
        cell.options.stop.interrupted = &watch.flag();
        cell.options.stop.hurried = &watch.hurry();
        SessionInput input = session_input(plan.scenes[cell.scene]);
        input.references = references.of(input);
        cell = with_load_found(plan, cell, input);
        const auto show = [&](double part) { ticker.at(item, part); };
        result.cells[todo[item]] = plan.study.sustained ? run_sustained(plan, cell, input, show)
                                                        : run_plain(plan, cell, input, show);
        if (watch.raised()) {  // the session may have been cut
          result.cells[todo[item]] = {};
          break;
        }
        write_record(folder, cell, result.cells[todo[item]]);
        ++done;
        ticker.at(item, 1.0);
      } catch (...) {
        const std::lock_guard guard(failed_mutex);
        if (!failed) failed = std::current_exception();
        next = todo.size();
      }
    }
  };
  {
    std::vector<std::jthread> pool;
    for (std::size_t i = 1; i < std::min(threads, todo.size()); ++i) pool.emplace_back(work);
    work();
  }
  if (failed && !watch.raised()) std::rethrow_exception(failed);
  result.interrupted = watch.raised() && done < todo.size();
  result.ran = done;
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace forefeel
