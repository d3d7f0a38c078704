#include "scheduling/placement/placement.hpp"

#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "approx/model/model_options.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/states/energy_jet.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/placement/covering.hpp"
#include "scheduling/placement/estimate_points.hpp"

namespace forefeel {
namespace {

constexpr double start_share = 0.75;    // of the half box: where the first eight corners lie
constexpr std::size_t most_rounds = 5;  // of truth

// uniform: how many of the first values the quantiles are of; the maximum is of all.
ErrorQuantiles quantiles_of(std::span<const double> values, std::size_t uniform) {
  ErrorQuantiles result;
  if (uniform == 0) return result;
  std::vector<double> sorted(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(uniform));
  std::ranges::sort(sorted);
  result.p50 = quantile(sorted, 0.5, QuantileRule::nearest);
  result.p95 = quantile(sorted, 0.95, QuantileRule::nearest);
  result.max = *std::ranges::max_element(values);
  return result;
}

// A tight solve. The stop token is checked after each continuation step.
State solve_unless_stopped(Solver& solver, const Vec3& x, const PlacementOptions& options) {
  struct Stopped {};
  solver.watch([&](double) {
    if (options.stop.stop_requested()) throw Stopped();
  });
  try {
    return solver
        .reference(x, options.space.spacing,
                   {.want_displacements = options.want_displacements, .jet = options.jet})
        .state;
  } catch (const Stopped&) {
    State state;
    state.at = x;
    state.solve.status = SolveStatus::cancelled;
    return state;
  }
}

// Tight solves at many positions; the answers do not depend on the threads.
std::vector<State> solve_all(const std::shared_ptr<const Body>& body, std::span<const Vec3> at,
                             const PlacementOptions& options, int threads,
                             const std::function<void(std::size_t)>& done) {
  std::vector<State> states(at.size());
  std::size_t finished = 0;
#pragma omp parallel num_threads(threads)
  {
    Solver solver(body);
#pragma omp for schedule(dynamic, 1)
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (options.stop.stop_requested()) {
        states[i].at = at[i];
        states[i].solve.status = SolveStatus::cancelled;
        continue;
      }
      states[i] = solve_unless_stopped(solver, at[i], options);
#pragma omp critical(forefeel_placement)
      {
        ++finished;
        if (omp_get_thread_num() == 0) done(finished);
      }
    }
  }
  return states;
}

std::size_t most_states(const PlacementOptions& options) {
  const std::size_t most =
      options.max_states > 0 ? options.max_states : lattice(options.space.box, options.space.spacing).size();
  return std::max<std::size_t>(most, 9);
}

EstimateOptions estimate_of(const PlacementOptions& options, std::size_t known) {
  EstimateOptions estimate = options.estimate;
  estimate.model = for_states(estimate.model, most_states(options) + known);
  return estimate;
}

class AdaptivePlacement {
 public:
  AdaptivePlacement(std::shared_ptr<const Body> body, const PlacementOptions& options,
                    std::span<const State> known, const std::function<void(State)>& sink,
                    const std::function<void(const PlacementProgress&)>& progress)
      : body_(std::move(body)),
        options_(options),
        sink_(sink),
        progress_(progress),
        space_(options.space),
        estimator_(space_, estimate_of(options, known.size())),
        points_(options.space.box),
        solver_(body_) {
    report_.threads = options.threads > 0 ? options.threads : omp_get_max_threads();
    report_.most_states = most_states(options);
    for (const State& state : known) {
      if (state.usable())
        report_.resumed += space_.insert(state).is_new ? 1 : 0;
      else
        failed_.at.push_back(state.at);
    }
    report_.failed = failed_.at.size();
    report_.linear = is_linear(*body_);
    // Half a grid cell, or a spacing.
    failed_.reach = std::min(options.space.spacing, options.space.box.size().maxCoeff() / 12);
  }

  PlacementReport run() {
    const auto start = std::chrono::steady_clock::now();
    if (report_.linear)
      place_linear();
    else
      place();
    report_.states = space_.size();
    report_.stopped = options_.stop.stop_requested();
    report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return report_;
  }

 private:
  struct Failed {
    std::vector<Vec3> at;  // positions without an equilibrium
    double reach = 0;      // no position within it is tried [m]
  };

  bool open() const { return !options_.stop.stop_requested() && space_.size() < report_.most_states; }

  bool has_failed(const Vec3& x) const {
    return std::ranges::any_of(failed_.at, [&](const Vec3& f) { return (f - x).norm() < failed_.reach; });
  }

  // Into the space and out to the file.
  void keep(State state) {
    if (state.solve.status == SolveStatus::cancelled) return;
    if (state.usable()) {
      space_.insert(state);
      ++report_.solved;
    } else {
      failed_.at.push_back(state.at);
      ++report_.failed;
    }
    sink_(std::move(state));
  }

  void solve(const Vec3& x) {
    if (!open() || space_.find(x).valid() || has_failed(x)) return;
    keep(solve_unless_stopped(solver_, x, options_));
  }

  Vec3 corner(int index, double share) const {
    const Box& box = options_.space.box;
    const Vec3 sign((index & 1) != 0 ? 1 : -1, (index & 2) != 0 ? 1 : -1, (index & 4) != 0 ? 1 : -1);
    return box.centre() + share * 0.5 * box.size().cwiseProduct(sign);
  }

  // Rest and three states not coplanar with it determine K, and the model reproduces a linear body exactly.
  void place_linear() {
    for (const int index : {0, 3, 5})
      if (space_.size() < 3) solve(corner(index, 1));
    refresh_estimate();
    report_.estimate_holds = report_.truth.holds = space_.size() >= 3;
    if (report_.estimate_holds) report_.estimate = {.p50 = 0, .p95 = 0, .max = 0};
    if (report_.estimate_holds) look_at_truth(0);
  }

  void place() {
    const Box& box = options_.space.box;
    solve(box.contains(Vec3::Zero()) ? Vec3(Vec3::Zero()) : Vec3(box.centre()));
    if (!jets_)
      for (const int index : {0, 3, 5, 6}) solve(corner(index, start_share));
    while (true) {
      refresh_estimate();
      if (report_.estimate_holds) {
        if (options_.stop.stop_requested() || truth_holds()) break;
        if (report_.truth.samples == 0) break;  // there is no truth to compare with
      }
      if (!open()) break;
      const std::optional<State> worst = report_.estimate_holds ? worst_truth() : std::nullopt;
      if (worst) {
        keep(*worst);
      } else if (!solve_next()) {
        break;
      }
    }
  }

  // Takes samples until the error holds on one that did not influence the placement; on a failure worst_truth() says.
  bool truth_holds() {
    for (std::size_t round = 0; round < most_rounds; ++round) {
      if (!look_at_truth(round)) return false;
      if (report_.truth.is_fresh) break;
    }
    return true;
  }

  // Of jets: where they serve most. Else the remaining corners first, then anywhere; false where no position is left.
  bool solve_next() {
    std::vector<Vec3> corners;
    for (const int index : {1, 2, 4, 7}) {
      const Vec3 x = corner(index, start_share);
      if (!jets_ && !space_.find(x).valid() && !has_failed(x)) corners.push_back(x);
    }
    std::span<const Vec3> candidates = points_.at;
    if (!corners.empty()) candidates = corners;
    std::vector<double> weights;
    for (const Vec3& x : candidates) weights.push_back(has_failed(x) ? 0 : 1);
    std::optional<std::size_t> next;
    if (jets_)
      next = covering_position(space_, candidates, estimates_, weights,
                               {.error = options_.error, .order = options_.jet});
    else if (const auto worst = worst_position(estimator_, space_, candidates, weights))
      next = worst->index;
    if (!next) return false;
    solve(candidates[*next]);
    return true;
  }

  void refresh_estimate() {
    std::vector<double> values;
    for (const Vec3& x : points_.at) {
      if (options_.stop.stop_requested()) return;
      values.push_back(estimator_(x));
    }
    estimates_ = std::move(values);
    report_.estimate = quantiles_of(estimates_, points_.uniform);
    report_.estimate_holds = report_.estimate.held() <= options_.error;
    progress_(
        {.states = space_.size(), .most_states = report_.most_states, .estimate = report_.estimate.held()});
  }

  // Random positions in the box, then its corners and random positions on its edges and faces, where the model
  // extrapolates. Corners, edges and faces leave out positions that are states already.
  std::vector<Vec3> truth_positions(std::size_t round) const {
    const Box& box = options_.space.box;
    const std::uint64_t seed = random::mix(options_.seed, round);
    const auto share = [&](std::uint64_t i) {
      const std::uint64_t key = random::mix(seed, i);
      return Vec3(random::uniform(random::mix(key, 1)), random::uniform(random::mix(key, 2)),
                  random::uniform(random::mix(key, 3)));
    };
    std::vector<Vec3> at;
    for (std::size_t i = 0; i < options_.truth_samples; ++i)
      at.push_back(box.low + box.size().cwiseProduct(share(i)));
    // 27 parts of the surface and the inside: -1, 0 or 1 on each axis, 0 for in between.
    std::uint64_t key = std::uint64_t{1} << 32;
    for (int part = 0; part < 27; ++part) {
      const int on[] = {part % 3 - 1, part / 3 % 3 - 1, part / 9 - 1};
      const int free = (on[0] == 0) + (on[1] == 0) + (on[2] == 0);
      for (int i = 0; free < 3 && i < (free == 0 ? 1 : 2); ++i) {
        Vec3 x = share(key++);
        for (int axis = 0; axis < 3; ++axis)
          if (on[axis] != 0) x[axis] = on[axis] > 0 ? 1 : 0;
        x = box.low + box.size().cwiseProduct(x);
        if (!space_.find(x).valid()) at.push_back(x);
      }
    }
    return at;
  }

  // Sample `round` of the truth, solved once; true where the error holds on it (or none is wanted).
  bool look_at_truth(std::size_t round) {
    report_.truth.holds = true;
    if (options_.truth_samples == 0) return true;
    round_ = round;
    if (rounds_.size() <= round) rounds_.resize(round + 1);
    std::vector<State>& truth = rounds_[round];
    if (truth.empty()) {
      const std::vector<Vec3> at = truth_positions(round);
      truth = solve_all(body_, at, options_, report_.threads, [&](std::size_t done) {
        progress_({.states = space_.size(),
                   .most_states = report_.most_states,
                   .estimate = report_.estimate.held(),
                   .truth_done = done,
                   .truth_total = at.size()});
      });
      report_.truth.solved += static_cast<std::size_t>(std::ranges::count_if(
          truth, [](const State& s) { return s.solve.status != SolveStatus::cancelled; }));
    }
    const auto usable = [](const State& state) { return state.usable(); };
    const auto within = truth.begin() + static_cast<std::ptrdiff_t>(options_.truth_samples);
    report_.truth.samples = static_cast<std::size_t>(std::count_if(truth.begin(), within, usable));
    report_.truth.on_surface = static_cast<std::size_t>(std::count_if(within, truth.end(), usable));
    report_.truth.unsolved = static_cast<std::size_t>(std::ranges::count_if(
        truth, [](const State& s) { return s.solve.status == SolveStatus::cancelled; }));
    report_.truth.failed =
        truth.size() - report_.truth.samples - report_.truth.on_surface - report_.truth.unsolved;
    report_.truth.error = true_error(estimator_, truth, options_.estimate.floor, options_.truth_samples);
    report_.truth.is_fresh = !truth_decided();
    report_.truth.checks.clear();
    std::copy_if(truth.begin(), within, std::back_inserter(report_.truth.checks),
                 [&](const State& state) { return usable(state) && !space_.find(state.at).valid(); });
    report_.truth.holds = !options_.stop.stop_requested() && report_.truth.error.held() <= options_.error;
    return report_.truth.holds;
  }

  bool truth_decided() const {
    return std::ranges::any_of(rounds_[round_],
                               [&](const State& state) { return space_.find(state.at).valid(); });
  }

  // Of the sampled positions that are not states yet, the one with the largest error.
  std::optional<State> worst_truth() {
    const State* worst = nullptr;
    double largest = 0;
    for (const State& state : rounds_[round_]) {
      if (!state.usable() || space_.find(state.at).valid()) continue;
      const double error = (estimator_.force(state.at) - state.force).norm() /
                           std::max(state.force.norm(), options_.estimate.floor);
      if (worst == nullptr || error > largest) {
        worst = &state;
        largest = error;
      }
    }
    return worst != nullptr ? std::optional<State>(*worst) : std::nullopt;
  }

  std::shared_ptr<const Body> body_;
  PlacementOptions options_;
  const std::function<void(State)>& sink_;
  const std::function<void(const PlacementProgress&)>& progress_;
  StateSpace space_;
  ErrorEstimator estimator_;
  EstimatePoints points_;
  std::vector<double> estimates_;  // at the points
  Solver solver_;
  Failed failed_;
  bool jets_ = options_.estimate.model.data == Data::jet;  // then one state has an estimate
  std::vector<std::vector<State>> rounds_;                 // of truth
  std::size_t round_ = 0;                                  // the round that was looked at last
  PlacementReport report_;
};

}  // namespace

double ErrorQuantiles::held() const {
  return std::max(p95, 0.5 * max);
}

std::optional<WorstPosition> worst_position(ErrorEstimator& estimator, const StateSpace& space,
                                            std::span<const Vec3> candidates,
                                            std::span<const double> weights) {
  std::optional<WorstPosition> worst;
  double largest = 0;
  std::vector<StateId> nearest;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Vec3& x = candidates[i];
    if (!(weights[i] > 0) || space.find(x).valid()) continue;
    const double estimate = estimator(x);
    double value = estimate;
    if (!std::isfinite(estimate)) {
      space.nearest(x, 1, nearest);
      value = 1 + (nearest.empty() ? 0.0 : (space[nearest[0]].at - x).norm() / space.options().spacing);
    }
    value *= weights[i];
    if (!worst || value > largest) {
      worst = {.index = i, .estimate = estimate};
      largest = value;
    }
  }
  return worst;
}

ErrorQuantiles true_error(ErrorEstimator& estimator, std::span<const State> truth, double floor,
                          std::size_t uniform) {
  std::vector<double> errors;
  std::size_t of_uniform = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const State& state = truth[i];
    if (!state.usable()) continue;
    errors.push_back((estimator.force(state.at) - state.force).norm() / std::max(state.force.norm(), floor));
    if (i < uniform) of_uniform = errors.size();
  }
  return quantiles_of(errors, of_uniform);
}

PlacementReport place_states(std::shared_ptr<const Body> body, const PlacementOptions& options,
                             std::span<const State> known, const std::function<void(State)>& sink,
                             const std::function<void(const PlacementProgress&)>& progress) {
  PlacementOptions whole = options;
  if (options.estimate.model.data == Data::jet && options.jet < 2) whole.jet = most_jet_order;
  return AdaptivePlacement(std::move(body), whole, known, sink, progress).run();
}

}  // namespace forefeel
