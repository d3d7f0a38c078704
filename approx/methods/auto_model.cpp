#include "approx/methods/auto_model.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <vector>

#include "approx/error/left_out.hpp"
#include "approx/error/place_models.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

constexpr double clearly_less = 0.8;        // of errors: then the law of each place is taken
constexpr double least_gain = 0.1;          // of a log of errors: less may be the noise of the same rows
constexpr std::size_t most_for_all = 1000;  // states for a model of all
constexpr std::size_t first_positions = 60, most_positions = 300;
constexpr std::size_t first_trials = 3;
constexpr std::size_t finalists = 3;
constexpr double ridge_gain = 1.02;  // a ridge is used if the error without it is larger by this factor

struct Candidate {
  ModelOptions model;
  bool all = false;  // all states in one model
  std::optional<FieldOptions> field = {};
  bool judge = false;  // the process that judges the positions, with the spline or alone
  double score = std::numeric_limits<double>::infinity();
};

// What the process of the known states of a trial gives at each held-out position; empty without a process.
using Judged = std::vector<ForceField::Prediction>;

std::vector<Judged> judge(const Trials& trials, const std::optional<FieldOptions>& field) {
  std::vector<Judged> judged(trials.each.size());
  if (!field) return judged;
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t t = 0; t < judged.size(); ++t) {
    const ForceField process(*trials.each[t].known, *field);
    for (const State& held : trials.each[t].held) judged[t].push_back(process.at(held.at));
  }
  return judged;
}

// At a position left out: the error, and its variance by the process, with noise [N^2]; NaN without a process.
struct Miss {
  double error = 0, variance = unknown;
};
using Misses = std::vector<Miss>;

// Of every `stride`-th position left out.
Misses misses(const Trial& trial, const Judged& judged, const Candidate& candidate, std::size_t stride) {
  Misses out;
  std::unique_ptr<ForceMaker> models;
  std::optional<ForceField> field;
  const bool own = candidate.field && !candidate.judge;
  if (own) field.emplace(*trial.known, *candidate.field);
  if (!candidate.field) models = models_of(*trial.known, candidate.model, candidate.all);
  for (std::size_t i = 0; i < trial.held.size(); i += stride) {
    const State& held = trial.held[i];
    const Vec3 foot = judged.empty() ? held.at : judged[i].foot;
    if (!candidate.field) {
      out.push_back({.error = (models->at({foot}).force(Place{foot}) - held.force).norm()});
      continue;
    }
    const ForceField::Prediction made = own ? field->at(held.at) : judged[i];
    const Vec3 force = own || candidate.field->spline.amplitude > 0 ? made.force : made.alone;
    const double noise = candidate.field->law.noise;
    out.push_back({.error = (force - held.force).norm(),
                   .variance = made.deviation * made.deviation + 3 * noise * noise});
  }
  return out;
}

// Which positions are tried: every `stride`-th of these trials.
struct Sampling {
  std::vector<std::size_t> trials;
  std::size_t stride = 1;
};

// most_trials: of caps and of other trials each.
Sampling sampling(const Trials& trials, std::size_t most_trials, std::size_t most) {
  Sampling of;
  for (const bool cap : {false, true}) {
    std::vector<std::size_t> kind;
    for (std::size_t t = 0; t < trials.each.size(); ++t)
      if (trials.each[t].cap == cap) kind.push_back(t);
    const std::size_t step = std::max<std::size_t>(1, (kind.size() + most_trials - 1) / most_trials);
    for (std::size_t i = 0; i < kind.size(); i += step) of.trials.push_back(kind[i]);
  }
  std::size_t positions = 0;
  for (const std::size_t t : of.trials) positions += trials.each[t].held.size();
  of.stride = std::max<std::size_t>(1, positions / most);
  return of;
}

// Errors of each candidate over the trials.
std::vector<Misses> misses(const Trials& trials, const std::vector<Judged>& judged,
                           std::span<const Candidate> candidates, const Sampling& of,
                           const std::function<void(double)>& show) {
  const std::size_t count = of.trials.size();
  std::vector<Misses> parts_of(count * candidates.size());
  std::size_t done = 0;
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t k = 0; k < parts_of.size(); ++k) {
    const std::size_t t = of.trials[k % count];
    parts_of[k] = misses(trials.each[t], judged[t], candidates[k / count], of.stride);
    std::size_t now = 0;
#pragma omp atomic capture
    now = ++done;
    if (show && omp_get_thread_num() == 0)
      show(static_cast<double>(now) / static_cast<double>(parts_of.size()));
  }
  std::vector<Misses> out(candidates.size());
  for (std::size_t k = 0; k < parts_of.size(); ++k)
    out[k / count].insert(out[k / count].end(), parts_of[k].begin(), parts_of[k].end());
  return out;
}

// The positions of misses(), in its order.
std::vector<SeenPlace> positions(const Trials& trials, const std::vector<Judged>& judged,
                                 const Sampling& of) {
  std::vector<SeenPlace> seen;
  for (const std::size_t t : of.trials)
    for (std::size_t i = 0; i < trials.each[t].seen.size(); i += of.stride) {
      seen.push_back(trials.each[t].seen[i]);
      if (!judged[t].empty()) seen.back().doubt = judged[t][i].own_deviation;
    }
  return seen;
}

// The trial of each of them.
std::vector<std::size_t> trials_of(const Trials& trials, const Sampling& of) {
  std::vector<std::size_t> trial;
  for (const std::size_t t : of.trials)
    for (std::size_t i = 0; i < trials.each[t].seen.size(); i += of.stride) trial.push_back(t);
  return trial;
}

// Student's t of n degrees of freedom that is exceeded on either side with a probability of 5 %.
double student(std::size_t n) {
  constexpr std::array exact{12.71, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306};
  return n <= exact.size() ? exact[n - 1] : 1.96 + 2.6 / static_cast<double>(n);
}

// Whether errors a are less than b, as far as the trials show: log of the ratio of their root mean squares, its mean
// over the trials beside the error of that mean. The trials are few and hold out different groups.
bool surely_less(const Misses& a, const Misses& b, const std::vector<std::size_t>& trial) {
  std::map<std::size_t, std::array<double, 2>> sums;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sums[trial[i]][0] += a[i].error * a[i].error;
    sums[trial[i]][1] += b[i].error * b[i].error;
  }
  double sum = 0, squares = 0;
  for (const auto& [t, of] : sums) {
    const double ratio = 0.5 * std::log(std::max(of[1], 1e-300) / std::max(of[0], 1e-300));
    sum += ratio;
    squares += ratio * ratio;
  }
  if (sums.size() < 2) return false;
  const auto n = static_cast<double>(sums.size());
  const double mean = sum / n, variance = std::max(0.0, squares / n - mean * mean) / (n - 1);
  return mean > least_gain && mean > student(sums.size() - 1) * std::sqrt(variance);
}

// Root mean square of the errors. Those outside count by the share of wanted places there.
double score(const Misses& errors, const std::vector<SeenPlace>& seen, double outside) {
  double sum[2] = {}, count[2] = {};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    sum[seen[i].outside] += errors[i].error * errors[i].error;
    count[seen[i].outside] += 1;
  }
  if (count[0] == 0 || count[1] == 0 || outside == 0)
    return std::sqrt((sum[0] + sum[1]) / static_cast<double>(errors.size()));
  return std::sqrt((1 - outside) * sum[0] / count[0] + outside * sum[1] / count[1]);
}

double share_outside(std::span<const SeenPlace> wanted) {
  if (wanted.empty()) return 0;
  return static_cast<double>(std::ranges::count_if(wanted, &SeenPlace::outside)) /
         static_cast<double>(wanted.size());
}

// Scores the candidates on some positions and sorts them, the best first; equal ones keep their order.
void sort_by_score(const Trials& trials, const std::vector<Judged>& judged, double outside,
                   std::vector<Candidate>& candidates, const std::function<void(double)>& show) {
  const Sampling some = sampling(trials, first_trials, first_positions);
  const std::vector<SeenPlace> seen = positions(trials, judged, some);
  const std::vector<Misses> errors = misses(trials, judged, candidates, some, show);
  for (std::size_t c = 0; c < candidates.size(); ++c) candidates[c].score = score(errors[c], seen, outside);
  std::ranges::stable_sort(candidates, {}, &Candidate::score);
}

bool has_stiffness(std::span<const State> states) {
  return std::ranges::any_of(states, &State::has_stiffness);
}

// Numbers of neighbours to try by one rule. 0: all states in one model.
std::vector<std::size_t> sizes_to_try(Select select, Data data, std::size_t states,
                                      const std::optional<std::size_t>& wished) {
  if (wished) return {*wished};
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
std::vector<Candidate> sets_to_try(std::span<const State> states, const ModelWishes& wishes) {
  const Data data = wishes.data.value_or(has_stiffness(states) ? Data::force_and_stiffness : Data::force);
  std::vector<Candidate> sets;
  for (const Kernel kernel : {Kernel::linear, Kernel::cubic, Kernel::quintic}) {
    if (wishes.kernel && *wishes.kernel != kernel) continue;
    if (kernel == Kernel::linear && data == Data::force_and_stiffness) continue;
    for (const Select select : {Select::nearest, Select::label}) {
      if (wishes.select && *wishes.select != select) continue;
      for (const std::size_t n : sizes_to_try(select, data, states.size(), wishes.neighbours))
        sets.push_back({.model = {.kernel = kernel,
                                  .data = data,
                                  .neighbours = n > 0 ? n : states.size(),
                                  .select = select},
                        .all = n == 0});
    }
  }
  return sets;
}

// Gaussian processes, if nothing is wished that they do not have.
std::vector<Candidate> fields_to_try(const AutoModelOptions& options, std::size_t states) {
  const ModelWishes& wishes = options.model;
  if (!options.field || wishes.kernel || wishes.ridge || wishes.neighbours || wishes.select) return {};
  const std::size_t near = options.field->neighbours;
  Candidate field{.model = {.neighbours = near > 0 ? near : states, .select = Select::nearest},
                  .all = near == 0,
                  .field = options.field,
                  .judge = true};
  std::vector<Candidate> fields{field};
  if (field.field->spline.amplitude > 0) {
    fields.push_back(field);
    fields.back().field->spline = {};
  }
  field.all = field.judge = false;
  field.field = local_field(*options.field, states);
  if (!field.field) return fields;
  field.model.neighbours = field.field->neighbours;
  fields.push_back(field);
  return fields;
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

// Mean of |e|^2 / (2 c v) + 3/2 log(c v), c: mean of |e|^2 / (3 v); less is better.
double likely_score(const Misses& misses) {
  double ratio = 0, spread = 0;
  for (const Miss& miss : misses) {
    ratio += miss.error * miss.error / miss.variance / static_cast<double>(misses.size());
    spread += std::log(miss.variance) / static_cast<double>(misses.size());
  }
  return 1.5 + 1.5 * (std::log(ratio / 3) + spread);
}

// The candidate with the least score; one without a ridge if it is about as good. A process, which the likelihood of
// all states chose, gives way only to what is surely better.
std::size_t best_of(const std::vector<Candidate>& candidates, const std::vector<Misses>& errors,
                    const std::vector<SeenPlace>& seen, const std::vector<std::size_t>& trial,
                    double outside) {
  std::vector<double> scores;
  for (const Misses& of : errors) scores.push_back(score(of, seen, outside));
  const auto best = static_cast<std::size_t>(std::ranges::min_element(scores) - scores.begin());
  std::size_t process = candidates.size();
  for (std::size_t c = 0; c < candidates.size(); ++c)
    if (candidates[c].judge && (process == candidates.size() || scores[c] < scores[process])) process = c;
  for (std::size_t c = 0; c < candidates.size(); ++c)
    if (candidates[c].field && candidates[c].field->local && process < candidates.size() &&
        (candidates[process].field->law.smoothness == Smoothness::matern32 ||
         likely_score(errors[c]) < likely_score(errors[process]) ||
         scores[c] < clearly_less * scores[process]))
      return c;
  if (process < candidates.size() && best != process && !surely_less(errors[best], errors[process], trial))
    return process;
  if (candidates[best].model.ridge > 0)
    for (std::size_t c = 0; c < candidates.size(); ++c)
      if (candidates[c].model.ridge == 0 && scores[c] <= ridge_gain * scores[best]) return c;
  return best;
}

}  // namespace

ModelOptions wished_model(const ModelWishes& wishes, bool stiffness, std::size_t states) {
  ModelOptions model;
  model.kernel = wishes.kernel.value_or(stiffness ? Kernel::quintic : Kernel::cubic);
  model.data = wishes.data.value_or(stiffness && model.kernel != Kernel::linear ? Data::force_and_stiffness
                                                                                : Data::force);
  model.neighbours = std::clamp<std::size_t>(wishes.neighbours.value_or(usual_neighbours(model.data)), 1,
                                             std::max<std::size_t>(states, 1));
  model.select = wishes.select.value_or(Select::label);
  model.ridge = wishes.ridge.value_or(0);
  return model;
}

AutoModel choose_model(std::span<const State> states, const AutoModelOptions& options,
                       std::span<const SeenPlace> wanted) {
  const ModelWishes& wishes = options.model;
  AutoModel chosen{.model = wished_model(wishes, has_stiffness(states), states.size())};
  if (states.size() < 8) return chosen;
  const Trials trials = leave_out(states, wanted, options.spacing);
  const double outside = share_outside(wanted);
  std::vector<Candidate> candidates = sets_to_try(states, wishes);
  const std::vector<Judged> judged = judge(trials, options.field);
  if (trials.each.empty() || candidates.empty()) return chosen;
  const auto stage = [&](double from, double to) -> std::function<void(double)> {
    if (!options.progress) return {};
    return [&options, from, to](double share) { options.progress(from + (to - from) * share); };
  };
  std::vector<Candidate> fields = fields_to_try(options, states.size());
  if (!fields.empty() && !trials.alike) {
    // What is best along presses may be anything between them: the blend of process and spline, which is safe.
    candidates.clear();
    std::erase_if(fields,
                  [&](const Candidate& c) { return c.judge && !same_process(*c.field, *options.field); });
  } else
    candidates = with_ridges(candidates, wishes.ridge, {0, 1e-4, 1e-2});
  sort_by_score(trials, judged, outside, candidates, stage(0, 0.4));
  candidates = with_ridges(best_sets(candidates, finalists), wishes.ridge,
                           {0, 1e-8, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1});
  sort_by_score(trials, judged, outside, candidates, stage(0.4, 0.7));
  candidates.resize(std::min(finalists, candidates.size()));
  if (!wishes.ridge && !candidates.empty() && candidates.front().model.ridge > 0) {
    candidates.insert(candidates.begin(), candidates.front());
    candidates.front().model.ridge = 0;
  }
  candidates.insert(candidates.end(), fields.begin(), fields.end());
  const Sampling all = sampling(trials, trials.each.size(), most_positions);
  const std::vector<Misses> errors = misses(trials, judged, candidates, all, stage(0.7, 1));
  const std::vector<SeenPlace> seen = positions(trials, judged, all);
  const std::size_t best = best_of(candidates, errors, seen, trials_of(trials, all), outside);
  chosen.model = candidates[best].model;
  chosen.model.neighbours = std::min(chosen.model.neighbours, states.size());
  chosen.all = candidates[best].all;
  chosen.field = candidates[best].field;
  std::vector<double> missed;
  for (const Miss& miss : errors[best]) missed.push_back(miss.error);
  const std::vector<double> expected = expected_quantiles(missed, seen, wanted, std::array{0.5, 0.95});
  chosen.p50 = expected[0];
  chosen.p95 = expected[1];
  chosen.positions = errors[best].size();
  chosen.groups = trials.groups;
  chosen.beyond = count_beyond(seen, wanted);
  chosen.alike = trials.alike;
  return chosen;
}

}  // namespace forefeel
