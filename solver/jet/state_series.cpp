#include "solver/jet/state_series.hpp"

#include <cmath>

namespace forefeel {
namespace {

constexpr int start_of(int degree) {
  return degree * (degree + 1) * (degree + 2) / 6;
}
int place_of(int a, int b, int c) {
  const int left = b + c;
  return start_of(a + left) + left * (left + 1) / 2 + c;
}

template <class Visit>
void for_each_power(const Visit& visit) {
  for (int degree = 0; degree <= 5; ++degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= 0; --b) visit(a, b, degree - a - b);
}

}  // namespace

Series product(const Series& p, const Series& q) {
  Series r = Series::Zero();
  for_each_power([&](int a, int b, int c) {
    const double left = p[place_of(a, b, c)];
    if (left == 0) return;
    for_each_power([&](int i, int j, int k) {
      if (a + b + c + i + j + k <= 5) r[place_of(a + i, b + j, c + k)] += left * q[place_of(i, j, k)];
    });
  });
  return r;
}

Series series_of(double e, const Vec3& f, const Mat3& k, const JetCoefficients& jet) {
  Series s;
  s << e, -f, 0.5 * k(0, 0), k(0, 1), k(0, 2), 0.5 * k(1, 1), k(1, 2), 0.5 * k(2, 2), jet;
  return s;
}

Series moved(const Series& p, const Vec3& x) {
  Series r = Series::Zero();
  constexpr double choose[6][6] = {{1},          {1, 1},          {1, 2, 1},
                                   {1, 3, 3, 1}, {1, 4, 6, 4, 1}, {1, 5, 10, 10, 5, 1}};
  for_each_power([&](int a, int b, int c) {
    const double value = p[place_of(a, b, c)];
    for (int i = 0; i <= a; ++i)
      for (int j = 0; j <= b; ++j)
        for (int k = 0; k <= c; ++k)
          r[place_of(i, j, k)] += value * choose[a][i] * choose[b][j] * choose[c][k] * std::pow(x[0], a - i) *
                                  std::pow(x[1], b - j) * std::pow(x[2], c - k);
  });
  return r;
}

Series turned(const Series& p, const Mat3& t) {
  return series_of(p[0], -t.transpose() * p.segment<3>(1), t.transpose() * stiffness_of(p) * t,
                   substituted(p.tail<static_cast<int>(jet_size)>(), t));
}

Series inverse_growth(const Vec3& x) {
  const double square = x.squaredNorm();
  const Series u = series_of(0, -2 * x / square, 2 * Mat3::Identity() / square, JetCoefficients::Zero());
  Series power = Series::Zero(), sum = Series::Zero();
  power[0] = 1;
  for (int n = 0; n <= 5; ++n, power = product(power, u))
    sum += (n % 2 == 0 ? 0.5 : -0.5) * (n + 1) * (n + 2) * power;
  return sum;
}

Series cut_after(const Series& p, int degree) {
  Series cut = p;
  cut.tail(series_size - start_of(degree + 1)).setZero();
  return cut;
}

Mat3 stiffness_of(const Series& p) {
  Mat3 k;
  k << 2 * p[4], p[5], p[6], p[5], 2 * p[7], p[8], p[6], p[8], 2 * p[9];
  return k;
}

}  // namespace forefeel
