#include <omp.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <map>
#include <utility>

#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state_outcome.hpp"
#include "solver/equilibrium/linear_body.hpp"
#include "solver/lattice/generate.hpp"
#include "solver/lattice/node_states.hpp"
#include "solver/lattice/sweep_plan.hpp"

namespace forefeel {
namespace {

// Solves the missing states by threads and gives them to the sink.
class Sweep {
 public:
  Sweep(std::shared_ptr<const Body> body, const LatticeOptions& options, const std::vector<State>& known,
        const std::function<void(State)>& sink, const std::function<void(std::size_t, std::size_t)>& progress)
      : body_(std::move(body)),
        d_(std::make_shared<const Discretisation>(discretise(*body_))),
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
      node.state.solve.seconds =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      emit(states.of(node));
    }
  }

  void run_sweep() {
    SweepOptions sweep = sweep_options(*body_, options_, options_.stop, solved_);
    sweep.precision = fitting_precision(d_);
    for (int i = 0; i < report_.threads; ++i)
      workers_.push_back(std::make_unique<Worker>(d_, sweep, *body_, options_));
    march_coarse();
    if (!stopped()) fill_cells();
  }

  void march_coarse() {
    for (const LatticeIndex& c : plan_.coarse()) {
      place_[c] = coarse_.size();
      coarse_.emplace_back();
    }
    std::map<int, std::vector<LatticeIndex>> levels;
    for (const LatticeIndex& c : plan_.coarse()) levels[level(c)].push_back(c);
    for (const auto& [number, members] : levels) {
      for_each(members.size(), [&, &list = members](Worker& worker, std::size_t i) {
        SweepNode& node = coarse_[place_.at(list[i])];
        node = solve_coarse_node(worker.sweep, list[i]);
        if (plan_.is_wanted(list[i])) emit(worker.states.of(node));
      });
      if (stopped()) return;
    }
  }

  // Solves the fine states by groups, outward from rest.
  void fill_cells() {
    for_each(plan_.groups().size(), [&](Worker& worker, std::size_t i) {
      for (const SweepNode& node : solve_fine_nodes(worker.sweep, plan_.groups()[i]))
        if (plan_.is_wanted(node.index)) emit(worker.states.of(node));
    });
  }

  template <class Work>
  void for_each(std::size_t count, const Work& work) {
#pragma omp parallel for schedule(dynamic) num_threads(report_.threads)
    for (std::size_t i = 0; i < count; ++i) {
      if (stopped()) continue;
      try {
        work(*workers_[static_cast<std::size_t>(omp_get_thread_num())], i);
      } catch (...) {
        keep_failure();
      }
    }
  }

  void keep_failure() {
#pragma omp critical(forefeel_generate)
    if (!failure_.first) {
      failure_.first = std::current_exception();
      failure_.seen.store(true);
    }
  }

  bool stopped() const {
    return options_.stop.stop_requested() || failure_.seen.load();
  }

  void emit(State state) {
    if (state.solve.status == SolveStatus::cancelled) return;
    std::exception_ptr thrown;
#pragma omp critical(forefeel_generate)
    {
      try {
        (state.usable() ? report_.solved : report_.failed) += 1;
        report_.inverted += has_inverted_elements(state);
        sink_(std::move(state));
        if (progress_) progress_(report_.resumed + report_.solved + report_.failed, plan_.positions());
      } catch (...) {
        thrown = std::current_exception();
      }
    }
    if (thrown) std::rethrow_exception(thrown);
  }

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
  std::vector<std::unique_ptr<Worker>> workers_;
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
  const auto start = std::chrono::steady_clock::now();
  GenerateReport report = Sweep(std::move(body), options, known, sink, progress).run();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace forefeel
