#include <omp.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <set>

#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state_outcome.hpp"
#include "solver/body/law.hpp"
#include "solver/equilibrium/linear_body.hpp"
#include "solver/lattice/generate.hpp"
#include "solver/lattice/sweep.hpp"

namespace forefeel {
namespace {

LatticeIndex index_of(const Vec3& x, double spacing) {
  LatticeIndex k{};
  for (std::size_t i = 0; i < 3; ++i)
    k[i] = static_cast<int>(std::lround(x[static_cast<Eigen::Index>(i)] / spacing));
  return k;
}

Vec3 position_of(const LatticeIndex& k, double spacing) {
  return spacing * Vec3(k[0], k[1], k[2]);
}

int level(const LatticeIndex& k) {
  return std::abs(k[0]) + std::abs(k[1]) + std::abs(k[2]);
}

// One step towards rest along an axis; the axes are tried from the longest component down.
std::vector<LatticeIndex> towards_rest(const LatticeIndex& k) {
  std::array<std::size_t, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(),
                   [&](std::size_t a, std::size_t b) { return std::abs(k[a]) > std::abs(k[b]); });
  std::vector<LatticeIndex> parents;
  for (const std::size_t axis : axes) {
    if (k[axis] == 0) continue;
    LatticeIndex p = k;
    p[axis] -= k[axis] > 0 ? 1 : -1;
    parents.push_back(p);
  }
  return parents;
}

bool is_coarse(const LatticeIndex& k) {
  return k[0] % 2 == 0 && k[1] % 2 == 0 && k[2] % 2 == 0;
}

// The coarse cell that a fine index lies in, named by its lowest corner.
LatticeIndex cell_of(const LatticeIndex& k) {
  LatticeIndex cell{};
  for (std::size_t axis = 0; axis < 3; ++axis) cell[axis] = static_cast<int>(std::floor(0.5 * k[axis]));
  return cell;
}

// Coarse corners around a fine index.
std::vector<LatticeIndex> corners_of(const LatticeIndex& k) {
  std::vector<LatticeIndex> corners{LatticeIndex{}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int low = static_cast<int>(std::floor(0.5 * k[axis]));
    std::vector<LatticeIndex> next;
    for (LatticeIndex c : corners)
      for (int side = low; side <= low + (k[axis] % 2 != 0 ? 1 : 0); ++side) {
        c[axis] = side;
        next.push_back(c);
      }
    corners.swap(next);
  }
  return corners;
}

// The missing states, the order in which they are solved, and their hand-over to the sink.
class Sweep {
 public:
  Sweep(std::shared_ptr<const Body> body, const GenerateOptions& options, const std::vector<State>& known,
        const std::function<void(State)>& sink, const std::function<void(std::size_t, std::size_t)>& progress)
      : body_(std::move(body)),
        d_(std::make_shared<const Discretisation>(discretise(*body_))),
        options_(options),
        sink_(sink),
        progress_(progress) {
    report_.threads = options.threads > 0 ? options.threads : omp_get_max_threads();
    std::set<LatticeIndex> there;
    for (const State& state : known) {
      const LatticeIndex k = index_of(state.at, options.spacing);
      if ((state.at - position_of(k, options.spacing)).norm() < 1e-6 * options.spacing) there.insert(k);
    }
    for (const Vec3& x : lattice(options.box, options.spacing)) {
      const LatticeIndex k = index_of(x, options.spacing);
      all_.insert(k);
      if (there.count(k) != 0)
        ++report_.resumed;
      else
        missing_.push_back(k);
    }
    wanted_.insert(missing_.begin(), missing_.end());
  }

  GenerateReport run() {
    if (!missing_.empty()) is_linear(*body_) ? run_linear() : run_sweep();
    if (failure_) std::rethrow_exception(failure_);
    return report_;
  }

 private:
  void run_linear() {
    NewtonSolver newton(d_);
    const LinearBody linear(*d_, newton);
    for (const LatticeIndex& k : missing_) {
      if (stopped()) return;
      SweepNode node;
      const auto start = std::chrono::steady_clock::now();
      node.state = linear.state(position_of(k, options_.spacing), node.field);
      node.state.parent = Vec3::Zero();
      node.state.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      emit(node);
    }
  }

  void run_sweep() {
    SweepOptions sweep;
    sweep.spacing = options_.spacing;
    const bool soft = law_entry(body_->material.law).softens || body_->material.poisson >= 0.49;
    sweep.residual_tolerance = (soft ? 5 : 20) * options_.tolerance;
    sweep.stop = options_.stop;
    sweep.coarse = [this](const LatticeIndex& c) { return solved(c); };
    for (int i = 0; i < report_.threads; ++i) workers_.push_back(std::make_unique<SweepWorker>(d_, sweep));
    march_coarse();
    if (!stopped()) fill_cells();
  }

  // The coarse nodes that the missing states depend on, with all nodes on the paths from rest to them.
  void plan_coarse() {
    std::set<LatticeIndex> needed;
    std::vector<LatticeIndex> open;
    const auto need = [&](const LatticeIndex& c) {
      if (all_.count({2 * c[0], 2 * c[1], 2 * c[2]}) != 0 && needed.insert(c).second) open.push_back(c);
    };
    for (const LatticeIndex& k : missing_) {
      if (is_coarse(k)) {
        need(cell_of(k));
        continue;
      }
      for (int m = 0; m < 8; ++m) {  // a cell is solved as a whole, so all its corners are needed
        LatticeIndex c = cell_of(k);
        for (std::size_t axis = 0; axis < 3; ++axis) c[axis] += (m >> axis) & 1;
        need(c);
      }
    }
    while (!open.empty()) {
      const LatticeIndex c = open.back();
      open.pop_back();
      for (const LatticeIndex& p : towards_rest(c)) need(p);
    }
    for (const LatticeIndex& c : needed) {
      SweepNode node;
      node.index = c;
      node.state.at = position_of(c, 2 * options_.spacing);
      place_[c] = coarse_.size();
      coarse_.push_back(std::move(node));
    }
  }

  const SweepNode* solved(const LatticeIndex& c) const {
    const auto at = place_.find(c);
    return at != place_.end() && coarse_[at->second].solved() ? &coarse_[at->second] : nullptr;
  }

  void march_coarse() {
    plan_coarse();
    std::map<int, std::vector<std::size_t>> levels;
    for (std::size_t i = 0; i < coarse_.size(); ++i) levels[level(coarse_[i].index)].push_back(i);
    for (const auto& [number, members] : levels) {
      for_each(members.size(), [&, &list = members](SweepWorker& worker, std::size_t i) {
        SweepNode& node = coarse_[list[i]];
        std::vector<const SweepNode*> parents;
        const SweepNode* beyond = nullptr;
        for (const LatticeIndex& p : towards_rest(node.index))
          if (const SweepNode* parent = solved(p)) {
            LatticeIndex b = p;
            for (std::size_t axis = 0; axis < 3; ++axis) b[axis] += p[axis] - node.index[axis];
            if (parents.empty() && level(b) < level(p)) beyond = solved(b);
            parents.push_back(parent);
          }
        worker.solve_coarse(node, parents, beyond);
        if (wanted_.count({2 * node.index[0], 2 * node.index[1], 2 * node.index[2]}) != 0) emit(node);
      });
      if (stopped()) return;
    }
  }

  // Solves the fine states by coarse cells, outward from rest.
  void fill_cells() {
    std::map<LatticeIndex, std::vector<LatticeIndex>> cells;
    std::vector<LatticeIndex> order;
    for (const LatticeIndex& k : missing_) {
      if (is_coarse(k)) continue;
      const LatticeIndex cell = cell_of(k);
      auto& list = cells[cell];
      if (list.empty()) order.push_back(cell);
      list.push_back(k);
    }
    for_each(order.size(), [&](SweepWorker& worker, std::size_t i) {
      // The whole cell is solved even if a resumed file holds a part of it: values depend on the cell alone.
      std::vector<SweepNode> nodes;
      std::vector<std::vector<const SweepNode*>> corners;
      for (int m = 1; m < 8; ++m) {
        LatticeIndex k = order[i];
        for (std::size_t axis = 0; axis < 3; ++axis) k[axis] = 2 * k[axis] + ((m >> axis) & 1);
        if (all_.count(k) == 0) continue;
        SweepNode node;
        node.index = k;
        node.state.at = position_of(k, options_.spacing);
        corners.emplace_back();
        for (const LatticeIndex& c : corners_of(k))
          if (const SweepNode* corner = solved(c)) corners.back().push_back(corner);
        std::stable_sort(
            corners.back().begin(), corners.back().end(),
            [](const SweepNode* a, const SweepNode* b) { return level(a->index) < level(b->index); });
        nodes.push_back(std::move(node));
      }
      worker.solve_cell(nodes, corners);
      for (SweepNode& node : nodes)
        if (wanted_.count(node.index) != 0) emit(node);
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
    if (!failure_) {
      failure_ = std::current_exception();
      broken_.store(true);
    }
  }

  bool stopped() const {
    return options_.stop.stop_requested() || broken_.load();
  }

  void emit(const SweepNode& node) {
    if (node.state.status == SolveStatus::cancelled) return;
    State state = node.state;
    if (options_.want_displacements && state.usable()) {
      std::vector<double> u = d_->to_nodes(node.field.u.data());
      u.resize(3 * body_->mesh.nodes.size());
      state.displacements = std::make_shared<const std::vector<double>>(std::move(u));
    }
    std::exception_ptr thrown;
#pragma omp critical(forefeel_generate)
    {
      try {
        (state.usable() ? report_.solved : report_.failed) += 1;
        report_.inverted += has_inverted_elements(state);
        sink_(std::move(state));
        if (progress_) progress_(report_.resumed + report_.solved + report_.failed, all_.size());
      } catch (...) {
        thrown = std::current_exception();
      }
    }
    if (thrown) std::rethrow_exception(thrown);
  }

  std::shared_ptr<const Body> body_;
  std::shared_ptr<const Discretisation> d_;
  const GenerateOptions& options_;
  const std::function<void(State)>& sink_;
  const std::function<void(std::size_t, std::size_t)>& progress_;
  std::set<LatticeIndex> all_, wanted_;
  std::vector<LatticeIndex> missing_;  // outward from rest
  std::vector<SweepNode> coarse_;
  std::map<LatticeIndex, std::size_t> place_;
  std::vector<std::unique_ptr<SweepWorker>> workers_;
  GenerateReport report_;
  std::exception_ptr failure_;
  std::atomic<bool> broken_ = false;
};

}  // namespace

GenerateReport generate_lattice(std::shared_ptr<const Body> body, const GenerateOptions& options,
                                const std::vector<State>& known, const std::function<void(State)>& sink,
                                const std::function<void(std::size_t, std::size_t)>& progress) {
  const auto start = std::chrono::steady_clock::now();
  GenerateReport report = Sweep(std::move(body), options, known, sink, progress).run();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace forefeel
