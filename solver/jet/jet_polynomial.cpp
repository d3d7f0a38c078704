#include "solver/jet/jet_polynomial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace forefeel {
namespace {

constexpr std::array<double, 6> factorial{1, 1, 2, 6, 24, 120};

double multinomial(int a, int b, int c) {
  const auto of = [](int n) { return factorial[static_cast<std::size_t>(n)]; };
  return of(a + b + c) / (of(a) * of(b) * of(c));
}

template <class Visit>
void for_each(int degree, const Visit& visit) {
  for (int a = degree; a >= 0; --a)
    for (int b = degree - a; b >= 0; --b) visit(a, b, degree - a - b);
}

// The exponents of one entry of a full tensor with `degree` indices.
std::array<int, 3> exponents_of(std::size_t entry, int degree) {
  std::array<int, 3> power{};
  for (int i = 0; i < degree; ++i, entry /= 3) ++power[entry % 3];
  return power;
}

}  // namespace

JetCoefficients coefficients_of(const EnergyJet& jet) {
  JetCoefficients e;
  std::ranges::copy(jet.coefficients, e.data());
  return e;
}

JetCoefficients substituted(const JetCoefficients& e, const Mat3& t) {
  JetCoefficients result;
  std::size_t size = 9;
  for (int degree = 3; degree <= 5; ++degree) {
    size *= 3;
    std::vector<double> tensor(size), turned(size);
    for (std::size_t entry = 0; entry < size; ++entry) {
      const auto [a, b, c] = exponents_of(entry, degree);
      tensor[entry] = e[static_cast<Eigen::Index>(jet_index(a, b, c))] / multinomial(a, b, c);
    }
    // One index at a time: the first becomes the last.
    for (int index = 0; index < degree; ++index) {
      const std::size_t rest = size / 3;
      for (std::size_t r = 0; r < rest; ++r) {
        const Vec3 from(tensor[3 * r], tensor[3 * r + 1], tensor[3 * r + 2]), to = t.transpose() * from;
        for (std::size_t j = 0; j < 3; ++j) turned[j * rest + r] = to[static_cast<Eigen::Index>(j)];
      }
      tensor.swap(turned);
    }
    for (std::size_t entry = 0; entry < size; ++entry) {
      const auto [a, b, c] = exponents_of(entry, degree);
      result[static_cast<Eigen::Index>(jet_index(a, b, c))] = tensor[entry] * multinomial(a, b, c);
    }
  }
  return result;
}

JetMonomials jet_monomials(const Vec3& z) {
  std::array<std::array<double, 6>, 3> power{}, slope{}, bend{};
  for (std::size_t i = 0; i < 3; ++i) {
    power[i][0] = 1;
    for (std::size_t k = 1; k < 6; ++k) {
      power[i][k] = z[static_cast<Eigen::Index>(i)] * power[i][k - 1];
      slope[i][k] = static_cast<double>(k) * power[i][k - 1];
      bend[i][k] = static_cast<double>(k) * slope[i][k - 1];
    }
  }
  JetMonomials m;
  Eigen::Index at = 0;
  for (int degree = 3; degree <= 5; ++degree)
    for_each(degree, [&](int ia, int ib, int ic) {
      const auto a = static_cast<std::size_t>(ia), b = static_cast<std::size_t>(ib),
                 c = static_cast<std::size_t>(ic);
      const double x = power[0][a], y = power[1][b], w = power[2][c];
      const double dx = slope[0][a], dy = slope[1][b], dw = slope[2][c];
      m.value[at] = x * y * w;
      m.gradient.row(at) << dx * y * w, x * dy * w, x * y * dw;
      m.hessian.row(at) << bend[0][a] * y * w, x * bend[1][b] * w, x * y * bend[2][c], dx * dy * w,
          dx * y * dw, x * dy * dw;
      ++at;
    });
  return m;
}

JetTerms jet_sum(const JetCoefficients& e, const JetMonomials& at, int degree) {
  const auto count = static_cast<Eigen::Index>(jet_terms_of_order(degree - 1));
  JetTerms sum;
  sum.energy = e.head(count).dot(at.value.head(count));
  sum.gradient = at.gradient.topRows(count).transpose() * e.head(count);
  const Eigen::Matrix<double, 6, 1> h = at.hessian.topRows(count).transpose() * e.head(count);
  sum.hessian << h[0], h[3], h[4], h[3], h[1], h[5], h[4], h[5], h[2];
  return sum;
}

double series_radius(const Mat3& k, const JetCoefficients& jet) {
  constexpr double share = 2;
  std::array<double, 4> square{};
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int l = -1; l <= 1; ++l) {
        if (i == 0 && j == 0 && l == 0) continue;
        const Vec3 n = Vec3(i, j, l).normalized();
        const JetMonomials at = jet_monomials(n);
        square[0] += (k * n).squaredNorm();
        Vec3 below = Vec3::Zero();
        for (int degree = 3; degree <= 5; ++degree) {
          const Vec3 so_far = jet_sum(jet, at, degree).gradient;
          square[static_cast<std::size_t>(degree - 2)] += (so_far - below).squaredNorm();
          below = so_far;
        }
      }
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t m = 1; m <= 3; ++m)
    if (square[m] > 0)
      least = std::min(least, std::pow(share * std::sqrt(square[0] / square[m]), 1.0 / double(m)));
  return least;
}

}  // namespace forefeel
