// Quantiles against hand-worked values and those that the documentation of numpy prints for its methods
// `inverted_cdf`, `nearest` and `linear`.

#include "geometry/common/quantiles.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr auto inverted_cdf = QuantileRule::inverted_cdf;
constexpr auto nearest = QuantileRule::nearest;
constexpr auto linear = QuantileRule::linear;

}  // namespace

TEST_CASE("Each rule gives the values that numpy documents", "[quantiles]") {
  const std::vector<double> five{15, 20, 35, 40, 50};
  CHECK(quantile(five, 0.4, inverted_cdf) == 20);
  CHECK(quantile(five, 0.4, nearest) == 35);
  CHECK(quantile(five, 0.4, linear) == 20 + (0.4 * 4 - 1) * 15);  // 29
  CHECK(quantile(five, 0.05, inverted_cdf) == 15);
  CHECK(quantile(five, 0.3, inverted_cdf) == 20);
  CHECK(quantile(five, 0.5, inverted_cdf) == 35);
  // numpy.quantile([[10, 7, 4], [3, 2, 1]], 0.5) = 3.5
  const std::vector<double> six{1, 2, 3, 4, 7, 10};
  CHECK(quantile(six, 0.5, linear) == 3.5);
  CHECK(quantile(six, 0.5, inverted_cdf) == 3);
  CHECK(quantile(six, 0.5, nearest) == 4);  // of 2.5, halves up
}

TEST_CASE("At the ends, with one value and with none all rules agree", "[quantiles]") {
  const std::vector<double> values{-3, -1, 4, 8};
  for (const QuantileRule rule : {inverted_cdf, nearest, linear}) {
    CHECK(quantile(values, 0, rule) == -3);
    CHECK(quantile(values, 1, rule) == 8);
    for (const double share : {0.0, 0.3, 0.5, 1.0}) CHECK(quantile(std::array{7.0}, share, rule) == 7);
    CHECK(std::isnan(quantile({}, 0.5, rule)));
    CHECK(std::isnan(quantile_of({}, 0.5, rule)));
  }
  CHECK(std::isnan(median({})));
}

TEST_CASE("Order and NaN do not matter to quantile_of and median", "[quantiles]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(quantile_of({9, nan, 1, 5}, 0.5, linear) == 5);
  CHECK(quantile_of({nan}, 0.5, nearest) != quantile_of({nan}, 0.5, nearest));
  CHECK(median({9, nan, 1, 5}) == 5);
  CHECK(median({4, 1, 3, 2}) == 3);
  std::mt19937 draw(5);
  for (std::size_t n = 1; n < 40; ++n) {
    std::vector<double> values;
    for (std::size_t i = 0; i < n; ++i) values.push_back(static_cast<double>(draw() % 17));
    CHECK(median(values) == quantile_of(values, 0.5, nearest));
  }
}

TEST_CASE("At least the share of the sample lies at or below the inverted CDF, less of it below",
          "[quantiles]") {
  std::vector<double> values;
  for (int i = 0; i < 20; ++i) values.push_back(i);
  for (int tenth = 1; tenth <= 10; ++tenth) {
    const double q = quantile(values, tenth / 10.0, inverted_cdf);
    CHECK(q + 1 >= 2 * tenth);  // how many are at or below
    CHECK(q < 2 * tenth);       // how many are below
  }
}
