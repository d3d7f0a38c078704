// Weights of a shape: exact at states, at rest and for linear fields; the order at which the error falls.

#include "scheduling/shape/shape_weights.hpp"
#include "tests/support/test.hpp"

namespace {

std::vector<Vec3> scattered(std::size_t n, std::uint64_t seed, const Vec3& extent = Vec3::Constant(0.03)) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < n; ++i)
    places.push_back(extent.cwiseProduct(Vec3(uniform(random), uniform(random), uniform(random))));
  return places;
}

// Where the weights put the tip: for a field that is linear in x with slope 1.
Vec3 reached(const ShapeWeights& weights, const std::vector<Vec3>& places) {
  Vec3 x = weights.of_slope;
  for (std::size_t i = 0; i < places.size(); ++i) x += weights.of_states[i] * places[i];
  return x;
}

// u with u(0) = 0, its slope at rest, and third derivatives that do not vanish; lengths in units of 3 cm.
Vec3 field(const Vec3& x) {
  const Vec3 y = x / 0.03;
  return {std::sin(y[0]) * std::cos(0.7 * y[1]), std::expm1(0.5 * y[2]) + 0.2 * y[0] * y[1],
          std::tanh(y[1] + 0.3 * y[2])};
}
Mat3 slope_at_rest() {
  Mat3 v;
  v << 1, 0, 0, 0, 0, 0.5, 0, 1, 0.3;
  return v / 0.03;
}

Vec3 interpolated(const Vec3& x, const std::vector<Vec3>& places) {
  const ShapeWeights weights = shape_weights(x, places);
  Vec3 u = slope_at_rest() * weights.of_slope;
  for (std::size_t i = 0; i < places.size(); ++i) u += weights.of_states[i] * field(places[i]);
  return u;
}

}  // namespace

TEST_CASE("a linear field is exact, however many states there are and however they lie") {
  for (std::size_t n = 0; n <= 40; ++n)
    for (const Vec3& extent :
         {Vec3(0.03, 0.03, 0.03), Vec3(0.03, 0, 0), Vec3(0.03, 0.02, 0), Vec3(0.03, 0.03, 1e-7)}) {
      const std::vector<Vec3> places = scattered(n, 7 + n, extent);
      for (const Vec3& x : scattered(5, 100 + n, Vec3::Constant(0.06))) {
        INFO(n << " states, at " << x.transpose());
        const ShapeWeights weights = shape_weights(x, places);
        CHECK((reached(weights, places) - x).norm() < 1e-9 * 0.06);
        double sum = 0;
        for (const double w : weights.of_states) sum += std::abs(w);
        CHECK(sum <= most_weight);
      }
    }
}

TEST_CASE("at a state the shape is that of the state, at rest it is rest") {
  for (std::size_t n : {1, 2, 5, 6, 12, 32}) {
    const std::vector<Vec3> places = scattered(n, n);
    for (std::size_t i = 0; i < n; ++i) {
      const ShapeWeights weights = shape_weights(places[i], places);
      CHECK(weights.of_slope.norm() < 1e-9 * 0.03);
      for (std::size_t k = 0; k < n; ++k) CHECK(weights.of_states[k] == Approx(k == i ? 1 : 0).margin(1e-8));
    }
    const ShapeWeights rest = shape_weights(Vec3::Zero(), places);
    CHECK(rest.of_slope.norm() < 1e-9 * 0.03);
    for (const double w : rest.of_states) CHECK(w == Approx(0).margin(1e-8));
  }
}

TEST_CASE("with the quintic kernel a quadratic field is exact") {
  const std::vector<Vec3> places = scattered(20, 3);
  const auto quadratic = [](const Vec3& x) {
    return x[0] * x[0] - 2 * x[1] * x[2] + 3 * x[2] * x[2] + x[0] * x[1];
  };
  std::size_t tried = 0;
  for (const Vec3& x : scattered(30, 4)) {
    const ShapeWeights weights = shape_weights(x, places);
    if (weights.order != ShapeOrder::quintic) continue;
    ++tried;
    double value = 0;  // its slope at rest is zero
    for (std::size_t i = 0; i < places.size(); ++i) value += weights.of_states[i] * quadratic(places[i]);
    CHECK(value == Approx(quadratic(x)).margin(1e-12));
  }
  CHECK(tried > 10);
}

TEST_CASE("the error falls with the third power of the spacing") {
  const Vec3 middle(0.012, -0.012, 0.012);  // of every lattice
  std::vector<double> errors;
  for (const double h : {0.006, 0.003, 0.0015, 0.00075}) {
    std::vector<Vec3> places;
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j <= 2; ++j)
        for (int k = -2; k <= 2; ++k)
          if (const Vec3 p = middle + h * Vec3(i, j, k); i * i + j * j + k * k <= 4 && p.norm() > 1e-9)
            places.push_back(p);
    double sum = 0;
    for (const Vec3& offset : scattered(20, 5, Vec3::Constant(0.5))) {
      const Vec3 x = middle + h * offset;
      sum += (interpolated(x, places) - field(x)).norm();
    }
    errors.push_back(sum / 20);
  }
  INFO(errors[0] << ' ' << errors[1] << ' ' << errors[2] << ' ' << errors[3]);
  for (std::size_t i = 1; i < errors.size(); ++i) CHECK(errors[i] < errors[i - 1] / 6.5);
}
