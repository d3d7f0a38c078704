// Intervals against published quantiles, hand-worked numbers, SciPy where installed, and their coverage on
// data whose mean is known.

#include "scheduling/study/statistics.hpp"

#include "scheduling/motion/random.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

std::string output_of(const std::string& command) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  char buffer[256];
  while (pipe && std::fgets(buffer, sizeof buffer, pipe.get())) text += buffer;
  return text;
}

// Groups with means of deviation `between` and replicates of deviation `within` around them; true mean 1.
GroupedValues drawn(std::size_t groups, std::size_t replicates, double between, double within,
                    std::uint64_t seed) {
  GroupedValues values(groups);
  for (std::size_t g = 0; g < groups; ++g) {
    const double centre = 1 + between * random::normal(random::mix(seed, 1000 * g));
    for (std::size_t i = 0; i < replicates; ++i)
      values[g].push_back(centre + within * random::normal(random::mix(seed, 1000 * g + i + 1)));
  }
  return values;
}

}  // namespace

TEST_CASE("Student quantiles agree with the printed tables") {
  CHECK(student_quantile(0.975, 1) == Approx(12.7062).epsilon(1e-5));
  CHECK(student_quantile(0.975, 4) == Approx(2.77645).epsilon(1e-5));
  CHECK(student_quantile(0.95, 10) == Approx(1.81246).epsilon(1e-5));
  CHECK(student_quantile(0.025, 30) == Approx(-2.04227).epsilon(1e-5));
}

TEST_CASE("a Student interval by hand: over group means, or over the replicates of one group") {
  // Means 1, 2, 3: m = 2, s = 1, half width = 4.30265 / sqrt 3.
  const ConfidenceInterval groups = student_interval({{0, 2}, {2}, {3, 3, 3}});
  CHECK(groups.mean == Approx(2));
  CHECK(groups.high - groups.mean == Approx(4.302653 / std::sqrt(3.0)).epsilon(1e-6));
  CHECK(groups.mean - groups.low == Approx(groups.high - groups.mean));
  const ConfidenceInterval one = student_interval({{1, 2, 3}});
  CHECK(one.high == Approx(groups.high));
}

TEST_CASE("intervals of shares stay between 0 and 1: by hand, against the plain one, and turned round") {
  // Means 0.7, 0.9, 0.8: m = 0.8, s = 0.1; on the logit scale ln 4 +- 4.302653 (0.1 / sqrt 3) / 0.16.
  const GroupedValues three{{0.7}, {0.85, 0.95}, {0.8}};
  const ConfidenceInterval share = share_interval(three);
  CHECK(share.mean == Approx(0.8));
  CHECK(share.low == Approx(0.4585226097).epsilon(1e-8));
  CHECK(share.high == Approx(0.9497353076).epsilon(1e-8));
  CHECK(student_interval(three).high > 1.04);
  // Half of 50 replicates: se^2 = p (1 - p) / (n - 1), and with that the logit interval of the paper.
  std::vector<double> coins(50, 0.0);
  std::fill(coins.begin(), coins.begin() + 25, 1.0);
  const double half = student_quantile(0.975, 49) / std::sqrt(0.25 * 49);
  CHECK(share_interval({coins}).high == Approx(1 / (1 + std::exp(-half))));
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    GroupedValues shares(2 + seed % 5), rest;
    for (std::size_t g = 0; g < shares.size(); ++g)
      for (std::size_t i = 0; i < 3; ++i)
        shares[g].push_back(std::min(1.0, 1.3 * random::uniform(random::mix(seed, 10 * g + i))));
    for (const auto& group : shares) {
      rest.emplace_back();
      for (const double v : group) rest.back().push_back(1 - v);
    }
    const ConfidenceInterval a = share_interval(shares), b = share_interval(rest);
    CHECK(a.low >= 0);
    CHECK(a.low <= a.mean);
    CHECK(a.mean <= a.high);
    CHECK(a.high <= 1);
    CHECK(b.low == Approx(1 - a.high).margin(1e-9));
    CHECK(b.high == Approx(1 - a.low).margin(1e-9));
  }
  // Narrow intervals are the same as without the logit scale.
  const GroupedValues narrow{{0.5}, {0.5001}, {0.4999}};
  CHECK(share_interval(narrow).high == Approx(student_interval(narrow).high).epsilon(1e-6));
  const ConfidenceInterval full = share_interval({{1.0}, {1.0, 1.0}}), one = share_interval({{0.4}});
  CHECK(full.low == 1);
  CHECK(full.high == 1);
  CHECK(one.mean == 0.4);
  CHECK(std::isnan(one.high));
}

TEST_CASE("a ranking of shares has such intervals, and plain ones of the differences") {
  std::vector<Observation> seen;
  for (std::size_t block = 0; block < 3; ++block) {
    const double value = 0.9 + 0.05 * static_cast<double>(block);
    seen.push_back({.level = 0, .block = block, .group = block, .value = value});
    seen.push_back({.level = 1, .block = block, .group = block, .value = value - (block == 0 ? 0.9 : 0.0)});
  }
  const LevelRanking ranking = rank(seen, 2, true, {.shares = true}), plain = rank(seen, 2, true);
  REQUIRE(ranking.ranked.size() == 2);
  CHECK(plain.ranked[0].value.student.high > 1);
  CHECK(plain.ranked[1].value.student.high > 1);
  for (const Ranked& entry : ranking.ranked) CHECK(entry.value.student.high <= 1);
  CHECK(ranking.ranked[1].to_best.student.low < -1);  // a difference, and no share
  CHECK(ranking.ranked[1].to_best.student.low == plain.ranked[1].to_best.student.low);
}

TEST_CASE("too few values give a mean without an interval, none give neither") {
  for (const auto& interval : {student_interval({{4.0}}), bootstrap_interval({{4.0}, {}, {nan_value}})}) {
    CHECK(interval.mean == 4.0);
    CHECK(std::isnan(interval.low));
    CHECK(std::isnan(interval.high));
    CHECK_FALSE(interval.excludes_zero());
  }
  CHECK(std::isnan(student_interval({{}, {nan_value}}).mean));
  CHECK(std::isnan(bootstrap_interval({}).mean));
  CHECK(compare({{4.0}}).verdict() == 0);
}

TEST_CASE("groups weigh the same however many replicates they hold") {
  const GroupedValues values{{10, 10, 10, 10}, {0}};
  CHECK(student_interval(values).mean == Approx(5));
  CHECK(bootstrap_interval(values).mean == Approx(5));
}

TEST_CASE("equal values have an interval of no width") {
  const Comparison same = compare({{0.25, 0.25}, {0.25, 0.25}});
  CHECK(same.student.low == 0.25);
  CHECK(same.bootstrap.high == 0.25);
  CHECK(same.verdict() == 1);
  CHECK(compare({{0, 0}, {0, 0}}).verdict() == 0);
}

TEST_CASE("levels that differ by rounding are equal") {
  std::vector<Observation> seen;
  for (std::size_t block = 0; block < 6; ++block)
    for (std::size_t level = 0; level < 3; ++level)
      seen.push_back({level, block, block / 2,
                      0.3 * static_cast<double>(block + 1) *
                          (level == 1   ? 1 + 1e-12
                           : level == 2 ? 1.01
                                        : 1)});
  const Comparison rounded = compare_levels(seen, 1, 0), larger = compare_levels(seen, 2, 0);
  CHECK(rounded.won + rounded.lost == 0);
  CHECK(rounded.verdict() == 0);
  CHECK(larger.won == 6);
  const LevelRanking ranking = rank(seen, 2, false);
  CHECK((ranking.ranked[1].tied && ranking.ranked[1].to_best.lost + ranking.ranked[1].to_best.won == 0));
}

TEST_CASE("the bootstrap repeats with its seed, shifts and scales with the data") {
  const GroupedValues values = drawn(6, 4, 0.5, 0.3, 7);
  const ConfidenceInterval first = bootstrap_interval(values, {.seed = 3}),
                           again = bootstrap_interval(values, {.seed = 3});
  CHECK(first.low == again.low);
  CHECK(first.high == again.high);
  CHECK(bootstrap_interval(values, {.seed = 4}).low != first.low);
  GroupedValues moved = values;
  for (auto& group : moved)
    for (double& v : group) v = 100 - 2 * v;
  const ConfidenceInterval mirrored = bootstrap_interval(moved, {.seed = 3});
  CHECK(mirrored.high == Approx(100 - 2 * first.low).epsilon(1e-12));
  CHECK(mirrored.low == Approx(100 - 2 * first.high).epsilon(1e-12));
}

TEST_CASE("intervals cover the true mean about as often as they say") {
  constexpr std::size_t trials = 1500;
  std::size_t student = 0, bootstrap = 0, both = 0;
  for (std::size_t trial = 0; trial < trials; ++trial) {
    const GroupedValues values = drawn(5, 3, 0.4, 0.4, 50'000 + trial);
    const ConfidenceInterval s = student_interval(values);
    const ConfidenceInterval b = bootstrap_interval(values, {.resamples = 400, .seed = trial});
    const bool in_s = s.low <= 1 && 1 <= s.high, in_b = b.low <= 1 && 1 <= b.high;
    student += in_s ? 1 : 0;
    bootstrap += in_b ? 1 : 0;
    both += in_s || in_b ? 1 : 0;
  }
  const auto share = [](std::size_t n) { return static_cast<double>(n) / trials; };
  // Three standard errors of a share of 0.95 in 1500 trials: 0.017.
  CHECK(share(student) == Approx(0.95).margin(0.017));
  CHECK(share(bootstrap) > 0.80);  // known to be narrow with five groups
  CHECK(share(bootstrap) < share(student));
  CHECK(share(both) >= share(student));
}

TEST_CASE("a verdict needs both intervals") {
  CHECK(compare({{1.0, 1.1}, {0.9, 1.0}, {1.05, 1.0}}).verdict() == 1);
  CHECK(compare({{-1.0, -1.1}, {-0.9, -1.0}, {-1.05, -1.0}}).verdict() == -1);
  // Two groups: the bootstrap cannot leave [0.5, 3], Student with one degree of freedom is far wider.
  const Comparison two = compare({{0.5, 0.5}, {3, 3}});
  CHECK(two.bootstrap.low > 0);
  CHECK(two.student.low < 0);
  CHECK(two.verdict() == 0);
  CHECK(two.won == 4);
}

TEST_CASE("ranking pairs blocks, so that a hard trace does not hide a small difference") {
  std::vector<Observation> seen;
  for (std::size_t block = 0; block < 12; ++block) {
    const std::size_t trace = block / 2;
    const double hardness = 10 * random::normal(random::mix(1, trace)),
                 noise = 0.01 * random::normal(random::mix(2, block));
    seen.push_back({.level = 0, .block = block, .group = trace, .value = hardness});
    seen.push_back({.level = 1, .block = block, .group = trace, .value = hardness + 0.5 + noise});
    seen.push_back({.level = 2, .block = block, .group = trace, .value = hardness + 0.5 - noise});
  }
  const LevelRanking up = rank(seen, 3, true);
  REQUIRE(up.ranked.size() == 3);
  CHECK(up.blocks == 12);
  CHECK(up.ranked.back().level == 0);
  CHECK_FALSE(up.ranked.back().tied);
  CHECK(up.ranked.back().to_best.verdict() == -1);
  CHECK(up.ranked.front().tied);
  CHECK(up.ranked[1].tied);
  CHECK(up.ranked.front().value.student.low < 0);  // unpaired, nothing would be seen
  CHECK(rank(seen, 3, false).ranked.front().level == 0);
  const Comparison pair = compare_levels(seen, 1, 0);
  CHECK(pair.pairs == 12);
  CHECK(pair.groups == 6);
  CHECK(pair.student.mean == Approx(0.5).margin(0.02));
  CHECK(compare_levels(seen, 0, 1).student.mean == Approx(-pair.student.mean));
}

TEST_CASE("a block that lacks a contender is used for none, and counted") {
  std::vector<Observation> seen;
  for (std::size_t block = 0; block < 4; ++block)
    for (std::size_t level = 0; level < 2; ++level)
      if (!(block == 3 && level == 1))
        seen.push_back({.level = level,
                        .block = block,
                        .group = block,
                        .value = block == 2 && level == 0 ? nan_value : 1.0});
  const LevelRanking ranking = rank(seen, 2, true);
  CHECK(ranking.blocks == 2);
  CHECK(ranking.dropped == 2);
  CHECK(rank({}, 2, true).ranked.empty());
}

TEST_CASE("Student and bootstrap intervals agree with SciPy where it is installed",
          SLOW("compares with SciPy, which only run.sh all installs")) {
  const std::string python =
      "/usr/bin/python3 -c \""
      "import numpy as np, scipy.stats as s\n"
      "x = np.array([0.31, 0.42, 0.77, 0.05, 0.66, 0.58, 0.49, 0.93, 0.12, 0.38])\n"
      "t = s.t.interval(0.95, 9, x.mean(), s.sem(x))\n"
      "b = s.bootstrap((x,), np.mean, n_resamples=200000, method='percentile', random_state=1)\n"
      "from scipy.special import expit, logit\n"
      "h = s.t.ppf(0.975, 9) * s.sem(x) / (x.mean() * (1 - x.mean()))\n"
      "l = expit(logit(x.mean()) + np.array([-h, h]))\n"
      "print(repr(float(t[0])), repr(float(t[1])), float(b.confidence_interval.low), "
      "float(b.confidence_interval.high), repr(float(l[0])), repr(float(l[1])))\" 2>/dev/null";
  double low = 0, high = 0, b_low = 0, b_high = 0, l_low = 0, l_high = 0;
  if (std::sscanf(output_of(python).c_str(), "%lf %lf %lf %lf %lf %lf", &low, &high, &b_low, &b_high, &l_low,
                  &l_high) != 6)
    return skip("python3-scipy is not installed");
  const GroupedValues one{{0.31, 0.42, 0.77, 0.05, 0.66, 0.58, 0.49, 0.93, 0.12, 0.38}};
  const ConfidenceInterval student = student_interval(one);
  CHECK(student.low == Approx(low).epsilon(1e-9));  // SciPy's quantile itself is good to 2e-11
  CHECK(student.high == Approx(high).epsilon(1e-9));
  CHECK(share_interval(one).low == Approx(l_low).epsilon(1e-9));
  CHECK(share_interval(one).high == Approx(l_high).epsilon(1e-9));
  const ConfidenceInterval bootstrap = bootstrap_interval(one, {.resamples = 100'000});
  CHECK(bootstrap.low == Approx(b_low).margin(0.003));
  CHECK(bootstrap.high == Approx(b_high).margin(0.003));
}

TEST_CASE("p values, Holm's adjustment and the critical difference agree with published numbers") {
  // Student's sleep data (R's help of t.test, paired): t = -4.0621, p = 0.002833.
  const GroupedValues sleep{{-1.2}, {-2.4}, {-1.3}, {-1.3}, {0}, {-1.0}, {-1.8}, {-0.8}, {-4.6}, {-1.4}};
  CHECK(compare(sleep).p_value() == Approx(0.002833).epsilon(2e-4));
  CHECK(std::isnan(compare({{1.0}}).p_value()));
  // R: p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")
  const std::vector<double> adjusted = holm(std::vector{0.01, 0.04, nan_value, 0.03, 0.005});
  const double expected[] = {0.03, 0.06, 0, 0.06, 0.02};
  for (const std::size_t i : {0u, 1u, 3u, 4u}) CHECK(adjusted[i] == Approx(expected[i]));
  CHECK(std::isnan(adjusted[2]));
  // Demsar 2006, 3.2.2: four classifiers on 14 data sets.
  CHECK(critical_difference(4, 14) == Approx(1.25).epsilon(0.005));
}

TEST_CASE("mean ranks share ties; a level that does not compete has none and takes no place") {
  std::vector<Observation> seen;
  const double values[3][4] = {{0.9, 0.8, 0.8, 0.99}, {0.7, 0.8, 0.6, 0.99}, {0.9, 0.5, 0.6, 0.99}};
  for (std::size_t group = 0; group < 3; ++group)
    for (std::size_t level = 0; level < 4; ++level)
      seen.push_back({level, group, group, values[group][level]});
  const std::vector<std::size_t> beside{3};
  const LevelRanking ranking = rank(seen, 4, true, {}, beside);
  const double expected[] = {4.0 / 3, (2.5 + 1 + 3) / 3, (2.5 + 3 + 2) / 3};
  for (const Ranked& row : ranking.ranked) {
    if (row.level == 3)
      CHECK(std::isnan(row.mean_rank));
    else
      CHECK(row.mean_rank == Approx(expected[row.level]));
  }
}
