#include "block_body.hpp"
#include "region_body.hpp"
#include "solver/equilibrium/newton.hpp"
#include "tests/support/test.hpp"

namespace {

std::vector<double> ramp(std::size_t size) {
  std::vector<double> v(size);
  for (std::size_t i = 0; i < size; ++i) v[i] = std::sin(0.7 * static_cast<double>(i));
  return v;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b, std::size_t rows) {
  double most = 0, size = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    most = std::max(most, std::abs(a[i] - b[i]));
    size = std::max(size, std::abs(b[i]));
  }
  return most / size;
}

}  // namespace

TEST_CASE("a factor in single precision solves like an exact one within its rounding, alone and in lanes") {
  const auto d = std::make_shared<const Discretisation>(discretise(*block_body(Law::neo_hookean, 0.45, 2)));
  const std::vector<double> rest(static_cast<std::size_t>(d->local_size()), 0.0);
  const auto rows = static_cast<std::size_t>(3 * d->free_nodes);
  NewtonSolver exact(d), single(d, Precision::single);
  REQUIRE(exact.factorise(rest));
  REQUIRE(single.factorise(rest));
  REQUIRE(single.factor().precision() == Precision::single);
  const std::vector<double> right = ramp(rest.size());
  std::vector<double> a = right, b = right, lanes(rest.size() * lane_count);
  exact.factor().solve(a.data());
  single.factor().solve(b.data());
  CHECK(largest_difference(b, a, rows) < 1e-4);
  CHECK(largest_difference(b, a, rows) > 0);
  for (std::size_t i = 0; i < rest.size(); ++i)
    for (std::size_t l = 0; l < lane_count; ++l)
      lanes[i * lane_count + l] = right[i] * (1 + static_cast<double>(l));
  single.factor().solve_lanes(lanes.data());
  for (std::size_t l = 0; l < lane_count; ++l) {
    std::vector<double> one(rest.size());
    for (std::size_t i = 0; i < one.size(); ++i)
      one[i] = lanes[i * lane_count + l] / (1 + static_cast<double>(l));
    CHECK(largest_difference(one, a, rows) < 1e-4);
  }
}

TEST_CASE("stiffness and tangent of a factor in single precision are corrected to those of an exact one") {
  const auto d = std::make_shared<const Discretisation>(discretise(*block_body(Law::neo_hookean, 0.45, 2)));
  const std::vector<double> rest(static_cast<std::size_t>(d->local_size()), 0.0);
  NewtonSolver exact(d), single(d, Precision::single);
  REQUIRE(exact.factorise(rest));
  REQUIRE(single.factorise(rest));
  std::vector<double> wanted(3 * rest.size()), tangent(3 * rest.size());
  Mat3 stiffness, corrected;
  REQUIRE(exact.condense(rest, 0, wanted.data(), stiffness));
  REQUIRE(single.condense(rest, 0, tangent.data(), corrected));
  CHECK((corrected - stiffness).norm() < 1e-10 * stiffness.norm());
  CHECK(largest_difference(tangent, wanted, tangent.size()) < 1e-7);
}

TEST_CASE("single precision is used for an ordinary body, not beside a stiffness a billion times larger") {
  const Material soft{Law::neo_hookean, 5000, 0.4}, hard{Law::neo_hookean, 5e12, 0.4};
  CHECK(fitting_precision(std::make_shared<const Discretisation>(discretise(*region_body(soft, soft)))) ==
        Precision::single);
  CHECK(fitting_precision(std::make_shared<const Discretisation>(discretise(*region_body(soft, hard)))) ==
        Precision::exact);
}
