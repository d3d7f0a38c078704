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
         .tied = false});
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
    entry.tied = entry.to_best.verdict() == 0;
  }
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

}  // namespace forefeel
