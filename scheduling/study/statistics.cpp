#include "scheduling/study/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "geometry/common/quantiles.hpp"
#include "scheduling/motion/random.hpp"

namespace forefeel {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

GroupedValues finite_groups(const GroupedValues& values) {
  GroupedValues kept;
  for (const std::vector<double>& group : values) {
    std::vector<double> finite;
    std::ranges::copy_if(group, std::back_inserter(finite), [](double v) { return std::isfinite(v); });
    if (!finite.empty()) kept.push_back(std::move(finite));
  }
  return kept;
}

std::vector<double> group_means(const GroupedValues& groups) {
  std::vector<double> means;
  for (const std::vector<double>& group : groups) means.push_back(mean_of(group));
  return means;
}

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : seed_(seed) {}
  std::size_t below(std::size_t n) {
    const auto drawn =
        static_cast<std::size_t>(random::uniform(random::mix(seed_, counter_++)) * static_cast<double>(n));
    return std::min(drawn, n - 1);
  }

 private:
  std::uint64_t seed_, counter_ = 0;
};

double resampled_mean(const GroupedValues& groups, Draws& draws) {
  double sum = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const std::vector<double>& group = groups[draws.below(groups.size())];
    double part = 0;
    for (std::size_t i = 0; i < group.size(); ++i) part += group[draws.below(group.size())];
    sum += part / static_cast<double>(group.size());
  }
  return sum / static_cast<double>(groups.size());
}

std::size_t count(const GroupedValues& groups) {
  std::size_t total = 0;
  for (const auto& group : groups) total += group.size();
  return total;
}

// Values of each level by block, for blocks that hold all levels asked for.
struct Block {
  std::size_t group = 0;
  std::map<std::size_t, double> values;  // level -> value
};

std::map<std::size_t, Block> by_block(std::span<const Observation> observations) {
  std::map<std::size_t, Block> blocks;
  for (const Observation& seen : observations) {
    Block& block = blocks[seen.block];
    block.group = seen.group;
    if (std::isfinite(seen.value)) block.values[seen.level] = seen.value;
  }
  return blocks;
}

// 0 where two values differ by rounding alone, as those of sums in another order: else it would be sure of its sign.
double beyond_rounding(double a, double b) {
  constexpr double rounding = 1e-9, least = 0.01;  // a logarithm of a factor near 1 is as exact as one of 1 %
  return std::abs(a - b) <= rounding * std::max({std::abs(a), std::abs(b), least}) ? 0 : a - b;
}

template <class Value>
GroupedValues grouped(const std::map<std::size_t, Block>& blocks, const Value& value) {
  std::map<std::size_t, std::vector<double>> groups;
  for (const auto& [id, block] : blocks) groups[block.group].push_back(value(block));
  GroupedValues values;
  for (auto& [id, group] : groups) values.push_back(std::move(group));
  return values;
}

}  // namespace

double student_quantile(double probability, double freedom) {
  return boost::math::quantile(boost::math::students_t(freedom), probability);
}

ConfidenceInterval student_interval(const GroupedValues& values, double confidence) {
  const GroupedValues groups = finite_groups(values);
  if (groups.empty()) return {none, none, none};
  const std::vector<double> units = groups.size() > 1 ? group_means(groups) : groups.front();
  const double mean = mean_of(units);
  if (units.size() < 2) return {mean, none, none};
  double squares = 0;
  for (const double unit : units) squares += (unit - mean) * (unit - mean);
  const auto n = static_cast<double>(units.size());
  const double half = student_quantile(0.5 + confidence / 2, n - 1) * std::sqrt(squares / (n - 1) / n);
  return {mean, mean - half, mean + half};
}

ConfidenceInterval share_interval(const GroupedValues& values, double confidence) {
  const ConfidenceInterval plain = student_interval(values, confidence);
  const double m = plain.mean, spread = m * (1 - m), half = plain.high - m;
  if (!std::isfinite(half) || !(spread > 0)) return plain;
  const auto share = [&](double shift) {
    return 1 / (1 + (1 - m) / m * std::exp(-shift));
  };  // logit^-1(logit m + shift)
  return {m, share(-half / spread), share(half / spread)};
}

ConfidenceInterval bootstrap_interval(const GroupedValues& values, const BootstrapOptions& options) {
  const GroupedValues groups = finite_groups(values);
  if (groups.empty()) return {none, none, none};
  const double mean = mean_of(group_means(groups));
  if (count(groups) < 2) return {mean, none, none};
  Draws draws(options.seed);
  std::vector<double> means(options.resamples);
  for (double& m : means) m = resampled_mean(groups, draws);
  std::ranges::sort(means);
  const double tail = (1 - options.confidence) / 2;
  return {mean, quantile(means, tail, QuantileRule::linear), quantile(means, 1 - tail, QuantileRule::linear)};
}

int Comparison::verdict() const {
  if (student.low > 0 && bootstrap.low > 0) return 1;
  if (student.high < 0 && bootstrap.high < 0) return -1;
  return 0;
}

double Comparison::p_value() const {
  const std::size_t units = groups > 1 ? groups : pairs;
  const double half = 0.5 * (student.high - student.low);
  if (units < 2 || !std::isfinite(half)) return none;
  if (!(half > 0)) return student.mean == 0 ? 1 : 0;
  const auto freedom = static_cast<double>(units - 1);
  const double t = std::abs(student.mean) * student_quantile(0.975, freedom) / half;
  return 2 * boost::math::cdf(boost::math::complement(boost::math::students_t(freedom), t));
}

std::vector<double> holm(std::span<const double> p_values) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p_values.size(); ++i)
    if (std::isfinite(p_values[i])) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return p_values[i]; });
  std::vector<double> adjusted(p_values.begin(), p_values.end());
  double least = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    least = std::max(least, static_cast<double>(order.size() - k) * p_values[order[k]]);
    adjusted[order[k]] = std::min(least, 1.0);
  }
  return adjusted;
}

double critical_difference(std::size_t levels, std::size_t groups) {
  constexpr double q[] = {1.960, 2.344, 2.569, 2.728, 2.850, 2.948, 3.031, 3.102, 3.164, 3.219,
                          3.268, 3.313, 3.354, 3.391, 3.426, 3.458, 3.489, 3.517, 3.544};  // Demsar, table 5
  if (levels < 2 || levels - 2 >= std::size(q) || groups < 1) return none;
  const auto k = static_cast<double>(levels);
  return q[levels - 2] * std::sqrt(k * (k + 1) / (6 * static_cast<double>(groups)));
}

Comparison compare(const GroupedValues& differences, const BootstrapOptions& options) {
  const GroupedValues groups = finite_groups(differences);
  Comparison result{options.shares ? share_interval(groups, options.confidence)
                                   : student_interval(groups, options.confidence),
                    bootstrap_interval(groups, options), count(groups), groups.size()};
  for (const auto& group : groups)
    for (const double difference : group) {
      result.won += difference > 0 ? 1 : 0;
      result.lost += difference < 0 ? 1 : 0;
    }
  return result;
}

namespace {

// Mean over the groups of the rank of each competing level by its mean in the group; ties share their mean rank.
void set_mean_ranks(const std::map<std::size_t, Block>& blocks, bool larger_is_better,
                    std::span<const std::size_t> beside, std::vector<Ranked>& ranked) {
  std::map<std::size_t, std::map<std::size_t, double>> sums;  // group -> level -> sum
  for (const auto& [id, block] : blocks)
    for (const auto& [level, value] : block.values)
      sums[block.group][level] += larger_is_better ? -value : value;
  const auto competes = [&](std::size_t level) { return std::ranges::find(beside, level) == beside.end(); };
  for (Ranked& entry : ranked) {
    double total = 0;
    for (const auto& [group, of_level] : sums) {
      const double own = of_level.at(entry.level);
      double place = 1;
      for (const auto& [level, value] : of_level)
        if (level != entry.level && competes(level))
          place += beyond_rounding(value, own) == 0 ? 0.5 : value < own ? 1 : 0;
      total += place;
    }
    entry.mean_rank = competes(entry.level) ? total / static_cast<double>(sums.size()) : none;
  }
}

}  // namespace

void adjust(LevelRanking& ranking, std::span<const std::size_t> beside) {
  std::vector<double> p_values;
  for (std::size_t i = 0; i < ranking.ranked.size(); ++i) {
    const bool competes = std::ranges::find(beside, ranking.ranked[i].level) == beside.end();
    p_values.push_back(competes && i > 0 ? ranking.ranked[i].to_best.p_value() : none);
  }
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 0; i < ranking.ranked.size(); ++i) {
    Ranked& entry = ranking.ranked[i];
    entry.holm = adjusted[i];
    entry.tied = entry.to_best.verdict() == 0 || entry.holm > significant;
  }
}

LevelRanking rank(std::span<const Observation> observations, std::size_t levels, bool larger_is_better,
                  const BootstrapOptions& options, std::span<const std::size_t> beside) {
  std::map<std::size_t, Block> blocks = by_block(observations);
  LevelRanking ranking;
  ranking.dropped =
      std::erase_if(blocks, [&](const auto& entry) { return entry.second.values.size() < levels; });
  ranking.blocks = blocks.size();
  if (blocks.empty()) return ranking;
  for (std::size_t level = 0; level < levels; ++level)
    ranking.ranked.push_back(
        {.level = level,
         .value = compare(grouped(blocks, [&](const Block& b) { return b.values.at(level); }), options),
         .to_best = {},
         .tied = false,
         .holm = none,
         .mean_rank = none});
  std::ranges::stable_sort(ranking.ranked, [&](const Ranked& a, const Ranked& b) {
    return larger_is_better ? a.value.student.mean > b.value.student.mean
                            : a.value.student.mean < b.value.student.mean;
  });
  std::stable_partition(ranking.ranked.begin(), ranking.ranked.end(), [&](const Ranked& entry) {
    return std::ranges::find(beside, entry.level) == beside.end();
  });
  const std::size_t best = ranking.ranked.front().level;
  BootstrapOptions of_differences = options;
  of_differences.shares = false;
  for (Ranked& entry : ranking.ranked) {
    entry.to_best = compare(
        grouped(blocks,
                [&](const Block& b) { return beyond_rounding(b.values.at(entry.level), b.values.at(best)); }),
        of_differences);
  }
  set_mean_ranks(blocks, larger_is_better, beside, ranking.ranked);
  adjust(ranking, beside);
  return ranking;
}

Comparison compare_levels(std::span<const Observation> observations, std::size_t a, std::size_t b,
                          const BootstrapOptions& options) {
  std::map<std::size_t, Block> blocks = by_block(observations);
  std::erase_if(blocks, [&](const auto& entry) {
    return !entry.second.values.contains(a) || !entry.second.values.contains(b);
  });
  return compare(
      grouped(blocks,
              [&](const Block& block) { return beyond_rounding(block.values.at(a), block.values.at(b)); }),
      options);
}

std::optional<std::size_t> motions_needed(const Comparison& difference, std::optional<double> size) {
  const ConfidenceInterval& d = difference.student;
  const double mean = size.value_or(d.mean);
  if (difference.groups < 2 || !std::isfinite(d.low) || mean == 0) return {};
  const auto groups = static_cast<double>(difference.groups);
  const double spread = 0.5 * (d.high - d.low) * std::sqrt(groups) / student_quantile(0.975, groups - 1);
  for (std::size_t n = 2; n <= 1000; ++n) {
    const auto freedom = static_cast<double>(n - 1);
    const double quantiles = student_quantile(0.975, freedom) + student_quantile(0.8, freedom);
    if (std::abs(mean) >= quantiles * spread / std::sqrt(static_cast<double>(n))) return n;
  }
  return {};
}

}  // namespace forefeel
