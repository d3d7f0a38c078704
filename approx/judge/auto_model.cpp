#include "approx/judge/auto_model.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "approx/judge/position_groups.hpp"
#include "approx/select/updater.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_whole = 1500;  // states: above, patches are tried
constexpr std::size_t patches = 5, patch_states = 700;
constexpr std::size_t parts = 8;
constexpr std::size_t most_for_all = 1000;  // states for a model of all
constexpr std::size_t first_positions = 60, most_positions = 300;
constexpr std::size_t finalists = 3;

// What is known and what is left out.
struct Trial {
  std::unique_ptr<StateSpace> known;
  std::vector<State> held;
};

struct Candidate {
  ModelOptions model;
  bool all = false;  // all states in one model
  double score = std::numeric_limits<double>::infinity();
};

struct Trials {
  std::vector<Trial> each;
  std::size_t positions = 0, groups = 0;
};

void add_trials(std::span<const State> states, double inner, double spacing, Trials& trials) {
  std::vector<Vec3> at;
  Vec3 centre = Vec3::Zero();
  for (const State& s : states) {
    at.push_back(s.at);
    centre += s.at / static_cast<double>(states.size());
  }
  const PositionGroups groups = position_groups(at);
  if (groups.count < 3) return;
  const std::size_t count = std::min(parts, groups.count);
  const std::vector<std::uint32_t> part = spread_over_parts(at, groups, count);
  std::vector<char> used(groups.count, 1);
  if (inner < 1)  // the rim of a patch is no rim of the states
    for (std::size_t i = 0; i < at.size(); ++i)
      if (i > static_cast<std::size_t>(inner * static_cast<double>(at.size()))) used[groups.of[i]] = 0;
  trials.groups += static_cast<std::size_t>(std::ranges::count(used, 1));
  for (std::uint32_t p = 0; p < (inner < 1 ? 1 : count); ++p) {
    Trial trial{.known = std::make_unique<StateSpace>(StateSpaceOptions{.spacing = spacing}), .held = {}};
    for (std::size_t i = 0; i < states.size(); ++i) {
      State light = states[i];
      light.displacements.reset();
      if (part[groups.of[i]] == p && used[groups.of[i]])
        trial.held.push_back(std::move(light));
      else
        trial.known->insert(std::move(light));
    }
    trials.positions += trial.held.size();
    if (!trial.held.empty() && !trial.known->empty()) trials.each.push_back(std::move(trial));
  }
}

// Patches about states that lie far from each other, each ordered by distance from its middle.
void add_patches(std::span<const State> states, double spacing, Trials& trials) {
  std::vector<double> away(states.size(), std::numeric_limits<double>::infinity());
  std::size_t middle = 0;
  for (std::size_t patch = 0; patch < patches; ++patch) {
    std::vector<std::size_t> order(states.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto distance = [&](std::size_t i) { return (states[i].at - states[middle].at).squaredNorm(); };
    std::ranges::nth_element(order, order.begin() + patch_states, {}, distance);
    order.resize(patch_states);
    std::ranges::stable_sort(order, {}, distance);
    std::vector<State> near;
    for (const std::size_t i : order) near.push_back(states[i]);
    add_trials(near, 0.5, spacing, trials);
    for (std::size_t i = 0; i < states.size(); ++i) away[i] = std::min(away[i], distance(i));
    middle = static_cast<std::size_t>(std::ranges::max_element(away) - away.begin());
  }
}

// The model of all states at once, about their middle.
Model model_of_all(std::span<const State> states, const ModelOptions& options) {
  Vec3 middle = Vec3::Zero();
  for (const State& s : states) middle += s.at / static_cast<double>(states.size());
  return fit_model(states, options, middle);
}

// |f - f~| at every `stride`-th position left out [N].
std::vector<double> misses(const Trial& trial, const Candidate& candidate, std::size_t stride) {
  std::vector<double> out;
  const auto add = [&](const Model& model, const State& held) {
    out.push_back((model.force(held.at) - held.force).norm());
  };
  if (candidate.all) {
    std::vector<State> known;
    for (std::uint32_t id = 0; id < trial.known->size(); ++id) known.push_back((*trial.known)[StateId{id}]);
    const Model model = model_of_all(known, candidate.model);
    for (std::size_t i = 0; i < trial.held.size(); i += stride) add(model, trial.held[i]);
    return out;
  }
  ModelOptions options = candidate.model;
  options.neighbours = std::min(options.neighbours, trial.known->size());
  ModelUpdater updater(*trial.known, options);
  Model model;
  for (std::size_t i = 0; i < trial.held.size(); i += stride) {
    updater.forget();
    updater.update(trial.held[i].at, model);
    add(model, trial.held[i]);
  }
  return out;
}

// Errors of each candidate over all trials.
std::vector<std::vector<double>> misses(const Trials& trials, std::span<const Candidate> candidates,
                                        std::size_t most) {
  const std::size_t stride = std::max<std::size_t>(1, trials.positions / most);
  const std::size_t count = trials.each.size();
  std::vector<std::vector<double>> parts_of(count * candidates.size());
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t k = 0; k < parts_of.size(); ++k)
    parts_of[k] = misses(trials.each[k % count], candidates[k / count], stride);
  std::vector<std::vector<double>> out(candidates.size());
  for (std::size_t k = 0; k < parts_of.size(); ++k)
    out[k / count].insert(out[k / count].end(), parts_of[k].begin(), parts_of[k].end());
  return out;
}

double score(const std::vector<double>& errors) {
  double sum = 0;
  for (const double e : errors) sum += e * e;
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

// Scores the candidates and keeps the `count` best; equal ones in their order.
void keep_best(const Trials& trials, std::vector<Candidate>& candidates, std::size_t most,
               std::size_t count) {
  const std::vector<std::vector<double>> errors = misses(trials, candidates, most);
  for (std::size_t c = 0; c < candidates.size(); ++c) candidates[c].score = score(errors[c]);
  std::ranges::stable_sort(candidates, {}, &Candidate::score);
  candidates.resize(std::min(count, candidates.size()));
}

bool has_stiffness(std::span<const State> states) {
  return std::ranges::any_of(states, &State::has_stiffness);
}

// Numbers of neighbours to try by one rule. 0: all states in one model.
std::vector<std::size_t> sizes_to_try(Select select, Data data, std::size_t states,
                                      const AutoModelOptions& options) {
  if (options.neighbours) return {*options.neighbours};
  const std::size_t rows = data == Data::force ? 1 : 4;
  std::vector<std::size_t> sizes{25, 50};
  const bool all = select == Select::nearest && rows * states <= most_for_all;
  if (select == Select::nearest && data == Data::force) sizes.push_back(100);
  if (select == Select::nearest && data == Data::force && !all) sizes.push_back(200);
  std::erase_if(sizes, [&](std::size_t n) { return n >= states; });
  if (all) sizes.push_back(0);
  if (sizes.empty()) sizes.push_back(std::min<std::size_t>(states, 25));
  return sizes;
}

// Kernels and neighbour sets, without a ridge.
std::vector<Candidate> sets_to_try(std::span<const State> states, const AutoModelOptions& options) {
  const Data data = options.data.value_or(has_stiffness(states) ? Data::force_and_stiffness : Data::force);
  std::vector<Candidate> sets;
  for (const Kernel kernel : {Kernel::linear, Kernel::cubic, Kernel::quintic}) {
    if (options.kernel && *options.kernel != kernel) continue;
    if (kernel == Kernel::linear && data == Data::force_and_stiffness) continue;
    for (const Select select : {Select::nearest, Select::label}) {
      if (options.select && *options.select != select) continue;
      for (const std::size_t n : sizes_to_try(select, data, states.size(), options))
        sets.push_back({.model = {.kernel = kernel,
                                  .data = data,
                                  .neighbours = n > 0 ? n : states.size(),
                                  .select = select},
                        .all = n == 0});
    }
  }
  return sets;
}

std::vector<Candidate> with_ridges(const std::vector<Candidate>& sets, const std::optional<double>& given,
                                   std::initializer_list<double> ridges) {
  std::vector<Candidate> all;
  for (Candidate candidate : sets) {
    for (const double ridge : ridges) {
      candidate.model.ridge = given.value_or(ridge);
      all.push_back(candidate);
      if (given) break;
    }
  }
  return all;
}

// The best candidates of different sets.
std::vector<Candidate> best_sets(const std::vector<Candidate>& sorted, std::size_t count) {
  std::vector<Candidate> best;
  const auto same = [](const Candidate& a, const Candidate& b) {
    return a.model.kernel == b.model.kernel && a.model.neighbours == b.model.neighbours &&
           a.model.select == b.model.select;
  };
  for (const Candidate& c : sorted) {
    if (std::ranges::any_of(best, [&](const Candidate& b) { return same(b, c); })) continue;
    best.push_back(c);
    if (best.size() == count) break;
  }
  return best;
}

ModelOptions defaults(std::span<const State> states, const AutoModelOptions& options) {
  const bool stiffness = has_stiffness(states);
  ModelOptions model;
  model.kernel = options.kernel.value_or(stiffness ? Kernel::quintic : Kernel::cubic);
  model.data = options.data.value_or(stiffness && model.kernel != Kernel::linear ? Data::force_and_stiffness
                                                                                 : Data::force);
  model.neighbours =
      std::clamp<std::size_t>(options.neighbours.value_or(model.data == Data::force ? 100 : 25), 1,
                              std::max<std::size_t>(1, states.size()));
  model.select = options.select.value_or(Select::label);
  model.ridge = options.ridge.value_or(0);
  return model;
}

}  // namespace

AutoModel choose_model(std::span<const State> states, const AutoModelOptions& options) {
  AutoModel chosen{.model = defaults(states, options)};
  if (states.size() < 8) return chosen;
  Trials trials;
  if (states.size() <= most_whole)
    add_trials(states, 1, options.spacing, trials);
  else
    add_patches(states, options.spacing, trials);
  std::vector<Candidate> candidates = sets_to_try(states, options);
  if (trials.each.empty() || candidates.empty()) return chosen;
  candidates = with_ridges(candidates, options.ridge, {0, 1e-4, 1e-2});
  keep_best(trials, candidates, first_positions, candidates.size());
  candidates = with_ridges(best_sets(candidates, finalists), options.ridge,
                           {0, 1e-8, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1});
  keep_best(trials, candidates, first_positions, finalists);
  keep_best(trials, candidates, most_positions, 1);
  const std::vector<double> errors = misses(trials, candidates, most_positions).front();
  chosen.model = candidates.front().model;
  chosen.model.neighbours = std::min(chosen.model.neighbours, states.size());
  chosen.all = candidates.front().all;
  chosen.p50 = quantile_of(errors, 0.5);
  chosen.p95 = quantile_of(errors, 0.95);
  chosen.positions = errors.size();
  chosen.groups = trials.groups;
  return chosen;
}

}  // namespace forefeel
