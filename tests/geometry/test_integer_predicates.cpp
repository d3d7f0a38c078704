// Signs of determinants on integers against CGAL's arbitrary precision, on lattices and on points near
// lattices.

#include <CGAL/Gmpz.h>

#include "geometry/common/types.hpp"
#include "geometry/index/integer_predicates.hpp"
#include "tests/support/test.hpp"

namespace {

using Exact = CGAL::Gmpz;
using Row = std::array<Exact, 4>;

Exact exact(double x) {
  return Exact(std::ldexp(x, 200));
}  // an integer for every double from 2^-148 on
Row row(const std::array<double, 3>& p, const std::array<double, 3>& from) {
  Row result;
  result[3] = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    result[i] = exact(p[i]) - exact(from[i]);
    result[3] += result[i] * result[i];
  }
  return result;
}
Exact volume(const Row& a, const Row& b, const Row& c, std::size_t i, std::size_t j, std::size_t k) {
  return a[i] * (b[j] * c[k] - b[k] * c[j]) - a[j] * (b[i] * c[k] - b[k] * c[i]) +
         a[k] * (b[i] * c[j] - b[j] * c[i]);
}
int sign(const Exact& x) {
  return x > 0 ? 1 : x < 0 ? -1 : 0;
}

}  // namespace

TEST_CASE("signs on integers are those of arbitrary precision", "[integers]") {
  std::mt19937_64 draw(5);
  int zero_volumes = 0, zero_spheres = 0, refused = 0;
  for (int round = 0; round < 20000; ++round) {
    // Lattices of several spacings, some shifted, some with a coordinate one unit in the last place off.
    const double h = std::array{0.006, 1.0 / 3, 0.0125, 7e5}[round % 4],
                 shift = round % 3 == 0 ? 0.1 * h : 0.0;
    std::array<std::array<double, 3>, 5> p;
    for (auto& point : p)
      for (double& x : point) x = shift + h * static_cast<double>(static_cast<int>(draw() % 5) - 2);
    if (round % 5 == 0) p[draw() % 5][draw() % 3] = std::nextafter(p[1][1], 1e9);
    if (round % 7 == 0) p[draw() % 5][draw() % 3] = h * std::ldexp(static_cast<double>(draw()), -64);
    const GridPoints<5> grid(p);
    if (!grid.exact()) {
      ++refused;
      continue;
    }
    const Row a = row(p[0], p[4]), b = row(p[1], p[4]), c = row(p[2], p[4]), d = row(p[3], p[4]);
    const int orientation = sign(volume(a, b, c, 0, 1, 2));
    REQUIRE(orientation_sign(grid(0, 4), grid(1, 4), grid(2, 4)) == orientation);
    const int sphere = sign(d[3] * volume(a, b, c, 0, 1, 2) - c[3] * volume(a, b, d, 0, 1, 2) +
                            b[3] * volume(a, c, d, 0, 1, 2) - a[3] * volume(b, c, d, 0, 1, 2));
    REQUIRE(sphere_sign(grid(0, 4), grid(1, 4), grid(2, 4), grid(3, 4)) == sphere);
    zero_volumes += orientation == 0;
    zero_spheres += sphere == 0;
  }
  CHECK(zero_volumes > 1000);
  CHECK(zero_spheres > 1000);
  CHECK(refused < 10000);
}

TEST_CASE("points without a common grid are not decided here", "[integers]") {
  const auto of = [](double x) {
    return GridPoints<2>({std::array{1.0, 2.0, 3.0}, std::array{1.0, 2.0, x}}).exact();
  };
  CHECK(of(0));
  CHECK(of(-0.0));
  CHECK(of(-0.006));
  CHECK_FALSE(of(1e-17));
  CHECK_FALSE(of(1e-320));
  CHECK_FALSE(of(1e300));
  CHECK_FALSE(of(std::nan("")));
  CHECK_FALSE(of(INFINITY));
  CHECK_FALSE(GridPoints<1>({std::array{0.0, 0.0, 0.0}}).exact());
  // The largest differences there can be: 2^61 either way.
  const double most = std::nextafter(2.0, 0.0);
  const GridPoints<5> wide({std::array{most, most, most}, std::array{-most, most, -most},
                            std::array{most, -most, -most}, std::array{-most, -most, most},
                            std::array{-most, -most, -most}});
  REQUIRE(wide.exact());
  CHECK(orientation_sign(wide(0, 4), wide(1, 4), wide(2, 4)) ==
        sign(volume(row({most, most, most}, {-most, -most, -most}),
                    row({-most, most, -most}, {-most, -most, -most}),
                    row({most, -most, -most}, {-most, -most, -most}), 0, 1, 2)));
  CHECK(sphere_sign(wide(0, 4), wide(1, 4), wide(2, 4), wide(3, 4)) == 0);  // corners of a cube
}
