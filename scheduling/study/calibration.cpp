#include "scheduling/study/calibration.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "approx/error/leave_one_out.hpp"
#include "approx/measured/position_groups.hpp"
#include "approx/model/force_makers.hpp"
#include "geometry/common/quantiles.hpp"
#include "scheduling/motion/random.hpp"

namespace forefeel {
namespace {

// Mean ranks from 0.
std::vector<double> ranks_of(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t i = 0, j = 0; i < order.size(); i = j) {
    while (j < order.size() && values[order[j]] == values[order[i]]) ++j;
    for (std::size_t k = i; k < j; ++k) ranks[order[k]] = 0.5 * static_cast<double>(i + j - 1);
  }
  return ranks;
}

// All kinds at all positions on one known set.
std::vector<CalibrationSample> judge_set(const std::vector<State>& known, std::size_t set,
                                         const std::vector<State>& truth,
                                         const std::vector<CalibrationKind>& kinds,
                                         const CalibrationOptions& options) {
  StateSpace space(options.space);
  for (const State& state : known) space.insert(state);
  std::vector<CalibrationSample> samples;
  std::vector<Coverage> found;
  for (const State& state : truth) found.push_back(space.coverage(state.at));
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
    ModelOptions model_options = kinds[kind].model;
    model_options.neighbours = std::min(model_options.neighbours, std::max<std::size_t>(1, space.size()));
    model_options.length = options.space.spacing;
    PlaceModels models(space, model_options);
    for (std::size_t p = 0; p < truth.size(); ++p) {
      const Model& model = models.at({truth[p].at});
      CalibrationSample sample{.kind = kind, .set = set, .position = p, .label = found[p].label};
      sample.delta = found[p].delta;
      sample.spread = found[p].spread;
      sample.error =
          (model.force(truth[p].at) - truth[p].force).norm() / std::max(truth[p].force.norm(), options.floor);
      std::vector<State> used;
      for (const StateId id : model.states()) used.push_back(space[id]);
      sample.power = power_function(used, model_options, truth[p].at);
      samples.push_back(sample);
    }
  }
  return samples;
}

CalibrationCell make_cell(const std::vector<CalibrationSample>& samples, std::size_t kind, Label label,
                          double tolerance) {
  CalibrationCell cell{.kind = kind, .label = label};
  std::vector<double> errors;
  for (const CalibrationSample& s : samples)
    if (s.kind == kind && s.label == label) errors.push_back(s.error);
  std::ranges::sort(errors);
  cell.count = errors.size();
  cell.over =
      static_cast<std::size_t>(std::ranges::count_if(errors, [&](double e) { return !(e <= tolerance); }));
  cell.p50 = quantile(errors, 0.5, QuantileRule::nearest);
  cell.p90 = quantile(errors, 0.9, QuantileRule::nearest);
  cell.p95 = quantile(errors, 0.95, QuantileRule::nearest);
  cell.p99 = quantile(errors, 0.99, QuantileRule::nearest);
  cell.max = quantile(errors, 1, QuantileRule::nearest);
  if (cell.count == 0) return cell;
  cell.share = static_cast<double>(cell.over) / static_cast<double>(cell.count);
  const ShareInterval interval = wilson_interval(cell.over, cell.count);
  cell.low = interval.low;
  cell.high = interval.high;
  return cell;
}

CalibrationRanks make_ranks(const std::vector<CalibrationSample>& samples, std::size_t kind) {
  std::vector<double> error, label, delta, spread, power;
  for (const CalibrationSample& s : samples) {
    if (s.kind != kind) continue;
    error.push_back(s.error);
    label.push_back(static_cast<double>(s.label));
    delta.push_back(s.delta);
    spread.push_back(s.spread);
    power.push_back(s.power);
  }
  return {.kind = kind,
          .label = rank_correlation(label, error),
          .delta = rank_correlation(delta, error),
          .spread = rank_correlation(spread, error),
          .power = rank_correlation(power, error)};
}

}  // namespace

double rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> x, y;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    if (!std::isnan(a[i]) && !std::isnan(b[i])) x.push_back(a[i]), y.push_back(b[i]);
  if (x.size() < 2) return unknown;
  const std::vector<double> p = ranks_of(x), q = ranks_of(y);
  const double mean = 0.5 * static_cast<double>(p.size() - 1);
  double pp = 0, qq = 0, pq = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    pp += (p[i] - mean) * (p[i] - mean);
    qq += (q[i] - mean) * (q[i] - mean);
    pq += (p[i] - mean) * (q[i] - mean);
  }
  return pp > 0 && qq > 0 ? pq / std::sqrt(pp * qq) : unknown;
}

ShareInterval wilson_interval(std::size_t hits, std::size_t count) {
  if (count == 0) return {0, 1};
  constexpr double z = 1.959963984540054;
  const auto n = static_cast<double>(count);
  const double p = static_cast<double>(hits) / n, middle = p + z * z / (2 * n);
  const double half = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n)), whole = 1 + z * z / n;
  return {hits == 0 ? 0.0 : (middle - half) / whole, hits == count ? 1.0 : (middle + half) / whole};
}

std::vector<CalibrationKind> calibration_kinds(Select select) {
  const auto plain = [&](Kernel kernel) {
    return ModelOptions{.kernel = kernel, .data = Data::force, .neighbours = 100, .select = select};
  };
  const auto hermite = [&](Kernel kernel) {
    return ModelOptions{
        .kernel = kernel, .data = Data::force_and_stiffness, .neighbours = 25, .select = select};
  };
  return {{"r, force, n 100", plain(Kernel::linear)},
          {"r3, force, n 100", plain(Kernel::cubic)},
          {"r5, force, n 100", plain(Kernel::quintic)},
          {"r3, force+stiffness, n 25", hermite(Kernel::cubic)},
          {"r5, force+stiffness, n 25", hermite(Kernel::quintic)}};
}

std::vector<KnownSet> calibration_sets(const std::vector<State>& pool, const CalibrationOptions& options) {
  const Box& box = options.space.box;
  const double h = options.space.spacing;
  Eigen::Index axis = 0;
  options.inward.cwiseAbs().maxCoeff(&axis);
  const double side = options.inward[axis] < 0 ? -1 : 1, extent = box.size()[axis];
  const auto depth = [&](const Vec3& x) {
    return side * (x - box.centre())[axis];
  };  // inward from the middle [m]
  const auto draw = [&](const Vec3& x, std::uint64_t salt) {
    return random::uniform(random::mix(random::mix(options.seed, salt), random::position_key(x)));
  };
  const double slit = std::min(4.5 * h, 0.35 * extent), hole = std::min(2.6 * h, 0.3 * box.size().minCoeff());
  const auto cut = [&](const char* name, const auto& keep) {
    KnownSet set{name, {}};
    for (const State& state : pool)
      if (keep(state.at)) set.states.push_back(state);
    return set;
  };
  std::vector<KnownSet> sets;
  sets.push_back(cut("full", [](const Vec3&) { return true; }));
  sets.push_back(cut("blank", [&](const Vec3& x) { return depth(x) <= 0.1 * h; }));
  sets.push_back(cut("gap", [&](const Vec3& x) { return std::abs(depth(x)) >= slit - 1e-9 * h; }));
  sets.push_back(cut("sparse", [&](const Vec3& x) {
    return depth(x) <= 0.1 * h || draw(x, 1) < 0.5 * (1 - depth(x) / (0.5 * extent + h));
  }));
  sets.push_back(cut("hole", [&](const Vec3& x) { return (x - box.centre()).norm() > hole; }));
  sets.push_back(cut("thin", [&](const Vec3& x) { return draw(x, 2) < 0.12; }));
  sets.push_back(cut("corner", [&](const Vec3& x) { return ((x - box.centre()).array() <= 0.1 * h).all(); }));
  std::erase_if(sets, [](const KnownSet& set) { return set.states.size() < 4; });
  return sets;
}

std::vector<Vec3> calibration_positions(const Box& box, std::size_t count, std::uint64_t seed) {
  std::vector<Vec3> at;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Vec3 share(random::uniform(random::mix(seed + 101, 3 * i)),
                     random::uniform(random::mix(seed + 101, 3 * i + 1)),
                     random::uniform(random::mix(seed + 101, 3 * i + 2)));
    at.push_back(box.low + share.cwiseProduct(box.size()));
  }
  return at;
}

HeldOut hold_out(std::vector<State> states, std::size_t most, std::uint64_t seed) {
  constexpr std::size_t most_grouped = 20'000;  // finding groups takes O(n^2)
  std::vector<std::uint32_t> group(states.size());
  std::size_t count = states.size();
  std::iota(group.begin(), group.end(), 0u);
  if (states.size() <= most_grouped) {
    std::vector<Vec3> at;
    for (const State& s : states) at.push_back(s.at);
    PositionGroups found = position_groups(at);
    group = std::move(found.of);
    count = found.count;
  }
  std::vector<std::size_t> size(count, 0);
  for (const std::uint32_t g : group) ++size[g];
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t g) { return random::mix(seed + 211, g); });
  const std::size_t wanted = std::min(most, states.size() / 5);
  std::vector<char> held(count, 0);
  std::size_t taken = 0;
  for (const std::uint32_t g : order)
    if (taken + size[g] <= std::max<std::size_t>(wanted, 1)) held[g] = 1, taken += size[g];
  HeldOut parts;
  for (std::size_t i = 0; i < states.size(); ++i)
    (held[group[i]] ? parts.truth : parts.pool).push_back(std::move(states[i]));
  return parts;
}

Calibration calibrate(const std::vector<State>& pool, const std::vector<State>& truth,
                      const CalibrationOptions& options) {
  Calibration result;
  result.kinds = calibration_kinds(options.select);
  if (std::ranges::none_of(pool, &State::has_stiffness))  // measured forces alone
    std::erase_if(result.kinds,
                  [](const CalibrationKind& k) { return k.model.data == Data::force_and_stiffness; });
  std::vector<KnownSet> sets = calibration_sets(pool, options);
  std::vector<std::vector<CalibrationSample>> parts(sets.size());
#pragma omp parallel for schedule(dynamic) \
    num_threads(options.threads > 0 ? options.threads : omp_get_max_threads())
  for (std::size_t set = 0; set < sets.size(); ++set)
    parts[set] = judge_set(sets[set].states, set, truth, result.kinds, options);
  for (std::vector<CalibrationSample>& part : parts) {
    for (const CalibrationSample& s : part)
      if (s.kind == 0) ++result.positions[s.label];
    result.samples.insert(result.samples.end(), part.begin(), part.end());
  }
  for (std::size_t kind = 0; kind < result.kinds.size(); ++kind) {
    for (int label = 0; label < 4; ++label)
      result.table.push_back(make_cell(result.samples, kind, static_cast<Label>(label), options.tolerance));
    result.ranks.push_back(make_ranks(result.samples, kind));
  }
  for (KnownSet& set : sets) set.states.clear();
  result.sets = std::move(sets);
  return result;
}

}  // namespace forefeel
