#include <omp.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state_outcome.hpp"
#include "solver/equilibrium/linear_body.hpp"
#include "solver/lattice/generate.hpp"
#include "solver/lattice/node_states.hpp"
#include "solver/lattice/sweep_plan.hpp"
#include "solver/lattice/task_queue.hpp"

namespace forefeel {
namespace {

// Solves the missing states by threads and gives them to the sink.
class Sweep {
 public:
  Sweep(std::shared_ptr<const Body> body, const LatticeOptions& options, const std::vector<State>& known,
        const std::function<void(State)>& sink, const std::function<void(std::size_t, std::size_t)>& progress)
      : began_(std::chrono::steady_clock::now()),
        body_(std::move(body)),
        d_(analyse(*body_, Precision::single)),
        options_(options),
        sink_(sink),
        progress_(progress),
        plan_(options, known) {
    report_.threads = options.threads > 0 ? options.threads : omp_get_max_threads();
    report_.resumed = plan_.resumed();
  }

  GenerateReport run() {
    if (!plan_.missing().empty()) is_linear(*body_) ? run_linear() : run_sweep();
    if (failure_.first) std::rethrow_exception(failure_.first);
    report_.seconds = wall_seconds(began_);
    if (const double all = thread_seconds() - began_at_; report_.parallel.work == 0)
      report_.parallel = {.work = all, .path = all};
    return report_;
  }

 private:
  // One thread's.
  struct Worker {
    Worker(const std::shared_ptr<const Discretisation>& d, const SweepOptions& options, const Body& body,
           const GenerateOptions& wanted)
        : sweep(d, options), states(d, body, wanted) {}
    SweepWorker sweep;
    NodeStates states;
  };
  struct Failure {
    std::exception_ptr first;
    std::atomic<bool> seen = false;
  };

  void run_linear() {
    NewtonSolver newton(d_);
    const LinearBody linear(*d_, newton);
    NodeStates states(d_, *body_, options_);
    for (const LatticeIndex& k : plan_.missing()) {
      if (stopped()) return;
      SweepNode node;
      const auto start = std::chrono::steady_clock::now();
      node.state = linear.state(position_of(k, options_.spacing), node.field);
      node.state.solve.parent = Vec3::Zero();
      node.state.solve.seconds = wall_seconds(start);
      emit(states.of(node));
    }
  }

  void run_sweep() {
    SweepOptions sweep = sweep_options(*body_, options_, options_.stop, solved_);
    sweep.precision = fitting_precision(d_);
    for (const LatticeIndex& c : plan_.coarse()) place_.emplace(c, place_.size());
    coarse_.resize(place_.size());
    TaskQueue queue(pieces_of(plan_));
    const double before = thread_seconds() - began_at_;
#pragma omp parallel num_threads(report_.threads)
    {
      try {
        Worker worker(d_, sweep, *body_, options_);
        TaskQueue::Member member(queue);
        const WithCrew together(&member);
        while (const std::optional<LatticeTask> task = queue.take([this] { return stopped(); })) {
          const double start = thread_seconds();
          const NextTasks next = solve(worker, queue.piece(task->piece), *task);
          queue.done(*task, thread_seconds() - start, member, next);
        }
      } catch (...) {
        keep_failure();
      }
      queue.wake();
    }
    report_.parallel = queue.times(before, in_sink_);
  }

  NextTasks solve(Worker& worker, const SweepPiece& piece, const LatticeTask& task) {
    if (piece.is_coarse) {
      SweepNode& node = coarse_[place_.at(piece.states.front())];
      node = solve_coarse_node(worker.sweep, piece.states.front());
      if (plan_.is_wanted(node.index)) emit(worker.states.of(node));
      return {};
    }
    std::shared_ptr<SweepCell> cell = task.cell;
    switch (task.step) {
      case TaskStep::all:
        cell = std::make_shared<SweepCell>(cell_of(worker.sweep.options(), piece.states));
        worker.sweep.solve_together(*cell);
        if (cell->open.size() > 1) return {TaskStep::correct, cell->open.size(), cell};
        if (cell->open.size() == 1) worker.sweep.correct(*cell, 0);
        break;
      case TaskStep::correct:
        worker.sweep.correct(*cell, task.place);
        return {TaskStep::find_paths, 1, cell};
      case TaskStep::find_paths:
        break;
      case TaskStep::follow_path:
        worker.sweep.follow_path(*cell, task.place);
        emit_fine(worker, cell->nodes[cell->open[task.place]]);
        return {};
    }
    worker.sweep.find_paths(*cell);
    if (cell->open.size() == 1) worker.sweep.follow_path(*cell, 0);
    const bool is_last = cell->open.size() <= 1;
    for (std::size_t i = 0; i < cell->nodes.size(); ++i)
      if (is_last || !std::ranges::binary_search(cell->open, i)) emit_fine(worker, cell->nodes[i]);
    if (is_last) return {};
    return {TaskStep::follow_path, cell->open.size(), cell};
  }

  void emit_fine(Worker& worker, const SweepNode& node) {
    if (plan_.is_wanted(node.index)) emit(worker.states.of(node));
  }

  void keep_failure() {
    const std::lock_guard lock(mutex_);
    if (failure_.first) return;
    failure_.first = std::current_exception();
    failure_.seen.store(true);
  }

  bool stopped() const {
    return options_.stop.stop_requested() || failure_.seen.load();
  }

  void emit(State state) {
    if (state.solve.status == SolveStatus::cancelled) return;
    const std::lock_guard lock(mutex_);
    if (std::exchange(in_sink_now_, true)) return;  // it has thrown
    const double start = thread_seconds();
    (state.usable() ? report_.solved : report_.failed) += 1;
    report_.inverted += has_inverted_elements(state);
    sink_(std::move(state));
    if (progress_) progress_(report_.resumed + report_.solved + report_.failed, plan_.positions());
    in_sink_ += thread_seconds() - start;
    in_sink_now_ = false;
  }

  std::chrono::steady_clock::time_point began_;
  double began_at_ = thread_seconds();
  std::shared_ptr<const Body> body_;
  std::shared_ptr<const Discretisation> d_;
  const LatticeOptions& options_;
  const std::function<void(State)>& sink_;
  const std::function<void(std::size_t, std::size_t)>& progress_;
  const SweepPlan plan_;
  std::vector<SweepNode> coarse_;
  std::map<LatticeIndex, std::size_t> place_;
  const SolvedNodes solved_ = [this](const LatticeIndex& c) -> const SweepNode* {
    const auto at = place_.find(c);
    return at != place_.end() && coarse_[at->second].solved() ? &coarse_[at->second] : nullptr;
  };
  std::mutex mutex_;    // of all below; it does not spin, unlike OpenMP's
  double in_sink_ = 0;  // [s]
  bool in_sink_now_ = false;
  GenerateReport report_;
  Failure failure_;
};

}  // namespace

GenerateReport generate(const Body& body, StateSpace& space, const GenerateOptions& options) {
  std::vector<State> known;
  for (std::uint32_t id = 0; id < space.size(); ++id) known.push_back(space[StateId{id}]);
  const auto keep = [&](State state) {
    if (state.usable()) space.insert(std::move(state));
  };
  const std::shared_ptr<const Body> borrowed(std::shared_ptr<void>(), &body);
  return generate_lattice(borrowed, {options, space.options().spacing, space.options().box}, keep, {}, known);
}

GenerateReport generate_lattice(std::shared_ptr<const Body> body, const LatticeOptions& options,
                                const std::function<void(State)>& sink,
                                const std::function<void(std::size_t, std::size_t)>& progress,
                                const std::vector<State>& known) {
  return Sweep(std::move(body), options, known, sink, progress).run();
}

}  // namespace forefeel
