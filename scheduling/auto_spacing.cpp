#include "scheduling/auto_spacing.hpp"

#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "scheduling/halton.hpp"

namespace forefeel {
namespace {

constexpr int divisions[] = {2, 3, 4, 6, 8, 12, 16, 24};
constexpr double reference_steps = 24;  // of the continuation, over the longest side

// Tight solves at the positions, each at its first use.
class References {
 public:
  References(std::shared_ptr<const Body> body, std::vector<Vec3> at, double step, int threads)
      : body_(std::move(body)), at_(std::move(at)), states_(at_.size()), step_(step), threads_(threads) {}

  const std::vector<Vec3>& at() const { return at_; }
  const State& operator[](std::size_t i) const { return *states_[i]; }
  std::size_t solved() const { return solved_; }

  void solve(const std::vector<std::size_t>& wanted) {
    std::vector<std::size_t> missing;
    for (const std::size_t i : wanted)
      if (!states_[i]) missing.push_back(i);
    solved_ += missing.size();
    if (missing.empty()) return;
#pragma omp parallel num_threads(threads_)
    {
      Solver solver(body_);
#pragma omp for schedule(dynamic)
      for (std::size_t k = 0; k < missing.size(); ++k)
        states_[missing[k]] = solver.reference(at_[missing[k]], step_).state;
    }
  }

 private:
  std::shared_ptr<const Body> body_;
  std::vector<Vec3> at_;
  std::vector<std::optional<State>> states_;
  double step_;
  int threads_;
  std::size_t solved_ = 0;
};

AutoSpacingTrial try_spacing(const std::shared_ptr<const Body>& body, const AutoSpacingOptions& options,
                             double h, References& references, std::size_t& solves) {
  StateSpaceOptions space_options;
  space_options.spacing = h;
  space_options.box = options.box;
  space_options.coverage = options.coverage;
  StateSpace space(space_options);
  GenerateOptions lattice;
  lattice.spacing = h;
  lattice.box = options.box;
  lattice.threads = options.threads;
  std::vector<State> states;
  const GenerateReport report =
      generate_lattice(body, lattice, {}, [&](State s) { states.push_back(std::move(s)); }, {});
  solves += report.solved + report.failed;
  std::ranges::sort(states, [](const State& a, const State& b) {
    return std::lexicographical_compare(a.at.data(), a.at.data() + 3, b.at.data(), b.at.data() + 3);
  });
  for (State& state : states)
    if (state.usable()) space.insert(std::move(state));
  AutoSpacingTrial trial{.spacing = h, .states = space.size(), .safe = 0};
  if (space.empty()) return trial;

  std::vector<std::size_t> safe;
  for (std::size_t i = 0; i < references.at().size(); ++i)
    if (space.label(references.at()[i]) == Label::safe) safe.push_back(i);
  trial.safe = safe.size();
  if (safe.size() < options.least_safe) return trial;
  references.solve(safe);
  ModelOptions model = options.model;
  model.length = h;
  ModelUpdater updater(space, model);
  std::vector<double> errors;
  for (const std::size_t i : safe) {
    const State& truth = references[i];
    if (!truth.usable()) continue;
    updater.forget();
    const Vec3 force = updater.model_at(truth.at).force(truth.at);
    errors.push_back((force - truth.force).norm() / std::max(truth.force.norm(), options.floor));
  }
  if (errors.empty()) return trial;
  std::ranges::sort(errors);
  trial.p95 = errors[static_cast<std::size_t>(std::floor(0.95 * static_cast<double>(errors.size() - 1)))];
  trial.max = errors.back();
  return trial;
}

}  // namespace

AutoSpacingReport choose_spacing(std::shared_ptr<const Body> body, const AutoSpacingOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const double longest = options.box.size().maxCoeff();
  const int threads = options.threads > 0 ? options.threads : omp_get_max_threads();
  References references(body, halton_points(options.box, options.positions), longest / reference_steps, threads);
  AutoSpacingReport report;
  for (const int division : divisions) {
    report.spacing = longest / division;
    report.trials.push_back(try_spacing(body, options, report.spacing, references, report.solves));
    report.holds = report.trials.back().max <= options.tolerance;  // false where nothing could be judged
    if (report.holds) break;
  }
  report.solves += references.solved();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace forefeel
