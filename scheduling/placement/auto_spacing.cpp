#include "scheduling/placement/auto_spacing.hpp"

#include <omp.h>

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <chrono>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>

#include "approx/model/force_makers.hpp"
#include "scheduling/motion/random.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel {
namespace {

constexpr int divisions[] = {2, 3, 4, 6, 8, 12, 16, 24};
constexpr double reference_steps = 24;  // of the continuation, over the longest side
constexpr std::size_t at_a_time = 40;   // positions in a batch, before a spacing may be rejected
constexpr std::size_t most_draws = 20;  // of positions in the box, for each safe one that is wanted

std::vector<Vec3> draws(const Box& box, std::size_t n) {
  std::vector<Vec3> points;
  for (std::uint64_t i = 0; i < n; ++i) {
    const Vec3 share(random::uniform(random::mix(1934, 3 * i)), random::uniform(random::mix(1934, 3 * i + 1)),
                     random::uniform(random::mix(1934, 3 * i + 2)));
    points.push_back(box.low + box.size().cwiseProduct(share));
  }
  return points;
}

// Largest number of positions, of n, that may exceed the tolerance while the share stays bounded; -1 if n is too small.
int most_above(std::size_t n, const AutoSpacingOptions& options) {
  int most = -1;
  while (static_cast<std::size_t>(most + 1) < n &&
         share_bound(static_cast<std::size_t>(most + 1), n, options.confidence) <= options.allowed_share)
    ++most;
  return most;
}

bool wanted_to_end(const AutoSpacingOptions& options) {
  return options.interrupted && options.interrupted->load(std::memory_order_relaxed);
}

// Tight solves at the positions, each at its first use.
class References {
 public:
  References(std::shared_ptr<const Body> body, std::vector<Vec3> at, double step, int threads,
             const AutoSpacingOptions& options)
      : body_(std::move(body)),
        at_(std::move(at)),
        states_(at_.size()),
        step_(step),
        threads_(threads),
        options_(options) {}

  const std::vector<Vec3>& at() const { return at_; }
  const State& operator[](std::size_t i) const { return *states_[i]; }
  std::size_t solved() const { return solved_; }

  // Calls progress(done, total) as positions are solved.
  void solve(std::span<const std::size_t> wanted,
             const std::function<void(std::size_t, std::size_t)>& progress) {
    std::vector<std::size_t> missing;
    for (const std::size_t i : wanted)
      if (!states_[i]) missing.push_back(i);
    solved_ += missing.size();
    if (missing.empty()) return;
    std::size_t finished = 0;
#pragma omp parallel num_threads(threads_)
    {
      Solver solver(body_);
#pragma omp for schedule(dynamic)
      for (std::size_t k = 0; k < missing.size(); ++k) {
        states_[missing[k]] =
            wanted_to_end(options_) ? State{} : solver.reference(at_[missing[k]], step_).state;
#pragma omp critical(forefeel_auto_spacing)
        progress(++finished, missing.size());
      }
    }
  }

 private:
  std::shared_ptr<const Body> body_;
  std::vector<Vec3> at_;
  std::vector<std::optional<State>> states_;
  double step_;
  int threads_;
  const AutoSpacingOptions& options_;
  std::size_t solved_ = 0;
};

using Tell = std::function<void(std::size_t done, std::size_t total)>;

// The solved lattice of spacing h, in the order of positions; incomplete if the user interrupts.
std::vector<State> lattice_states(const std::shared_ptr<const Body>& body, const AutoSpacingOptions& options,
                                  double h, std::size_t& solves, const Tell& tell) {
  LatticeOptions lattice;
  lattice.spacing = h;
  lattice.box = options.box;
  lattice.threads = options.threads;
  std::vector<State> states;
  std::stop_source stop;
  lattice.stop = stop.get_token();
  const GenerateReport report = generate_lattice(
      body, lattice, [&](State s) { states.push_back(std::move(s)); },
      [&](std::size_t done, std::size_t total) {
        if (wanted_to_end(options)) stop.request_stop();
        tell(done, total);
      });
  solves += report.solved + report.failed;
  std::ranges::sort(states, [](const State& a, const State& b) {
    return std::lexicographical_compare(a.at.data(), a.at.data() + 3, b.at.data(), b.at.data() + 3);
  });
  return states;
}

AutoSpacingTrial try_spacing(const std::shared_ptr<const Body>& body, const AutoSpacingOptions& options,
                             AutoSpacingProgress now, References& references, std::size_t& solves) {
  const double h = now.spacing;
  const Tell tell = [&](std::size_t done, std::size_t total) {
    now.done = done;
    now.total = total;
    if (options.progress) options.progress(now);
  };
  StateSpaceOptions space_options;
  space_options.spacing = h;
  space_options.box = options.box;
  space_options.coverage = options.coverage;
  StateSpace space(space_options);
  for (State& state : lattice_states(body, options, h, solves, tell))
    if (state.usable()) space.insert(std::move(state));
  if (wanted_to_end(options)) return {};
  AutoSpacingTrial trial{.spacing = h, .states = space.size(), .safe = 0};
  if (space.empty()) return trial;

  std::vector<std::size_t> safe;
  for (std::size_t i = 0; i < references.at().size() && safe.size() < options.positions; ++i)
    if (space.label(references.at()[i]) == Label::safe) safe.push_back(i);
  const int most = most_above(safe.size(), options);
  if (most < 0) return trial;  // too few for any bound
  ModelOptions model = options.model;
  model.length = h;
  PlaceModels models(space, model);
  std::vector<double> errors;
  while (trial.safe < safe.size() && static_cast<int>(trial.above) <= most) {
    const std::span next =
        std::span(safe).subspan(trial.safe).first(std::min(at_a_time, safe.size() - trial.safe));
    now.checking = true;
    references.solve(next, tell);
    if (wanted_to_end(options)) return {};
    trial.safe += next.size();
    for (const std::size_t i : next) {
      const State& truth = references[i];
      double error = INFINITY;
      if (truth.usable()) {
        const Vec3 force = models.at({truth.at}).force(truth.at);
        error = (force - truth.force).norm() / std::max(truth.force.norm(), options.floor);
      }
      errors.push_back(error);
      trial.above += error <= options.tolerance ? 0 : 1;
    }
  }
  trial.share_bound = share_bound(trial.above, trial.safe, options.confidence);
  std::ranges::sort(errors);
  trial.p95 = errors[std::floor(0.95 * static_cast<double>(errors.size() - 1))];
  trial.max = errors.back();
  return trial;
}

}  // namespace

double share_bound(std::size_t k, std::size_t n, double confidence) {
  if (k >= n) return 1;
  return boost::math::binomial_distribution<>::find_upper_bound_on_p(static_cast<double>(n),
                                                                     static_cast<double>(k), 1 - confidence);
}

double finest_spacing(const Box& box) {
  return box.size().maxCoeff() / divisions[std::size(divisions) - 1];
}

AutoSpacingReport choose_spacing(std::shared_ptr<const Body> body, const AutoSpacingOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const double longest = options.box.size().maxCoeff();
  const int threads = options.threads > 0 ? options.threads : omp_get_max_threads();
  References references(body, draws(options.box, most_draws * options.positions), longest / reference_steps,
                        threads, options);
  AutoSpacingReport report;
  AutoSpacingProgress now{.trials = std::size(divisions)};
  for (const int division : divisions) {
    report.spacing = now.spacing = longest / division;
    ++now.trial;
    report.trials.push_back(try_spacing(body, options, now, references, report.solves));
    if ((report.interrupted = wanted_to_end(options))) return report;
    report.holds = report.trials.back().share_bound <= options.allowed_share;
    if (report.holds) break;
  }
  report.solves += references.solved();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace forefeel
