#include "geometry/states/energy_jet.hpp"

#include <algorithm>

namespace forefeel {

namespace {

constexpr std::size_t start_of_degree(int degree) {
  return degree == 3 ? 0 : degree == 4 ? 10 : 25;
}

struct Exponents {
  int a = 0, b = 0, c = 0;
};

constexpr std::array<Exponents, jet_size> all_exponents() {
  std::array<Exponents, jet_size> list{};
  std::size_t at = 0;
  for (int degree = 3; degree <= 5; ++degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= 0; --b) list[at++] = {a, b, degree - a - b};
  return list;
}
constexpr std::array<Exponents, jet_size> exponents = all_exponents();

}  // namespace

std::size_t jet_index(int a, int b, int c) {
  const int degree = a + b + c, below = degree - a;  // before (a, b): all of larger a, then of larger b
  return start_of_degree(degree) + static_cast<std::size_t>(below * (below + 1) / 2 + c);
}

const std::array<std::string, jet_size>& jet_names() {
  static const std::array<std::string, jet_size> names = [] {
    std::array<std::string, jet_size> list;
    for (std::size_t i = 0; i < jet_size; ++i) {
      const auto [a, b, c] = exponents[i];
      list[i] = "e" + std::to_string(a) + std::to_string(b) + std::to_string(c);
    }
    return list;
  }();
  return names;
}

std::size_t jet_terms_of_order(int order) {
  return order < 2 ? 0 : order == 2 ? 10 : order == 3 ? 25 : jet_size;
}

JetTerms jet_terms(const EnergyJet& jet, const Vec3& d, int degree) {
  // value, first and second derivative of t^k for each component
  std::array<std::array<double, 6>, 3> power{}, slope{}, bend{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double t = d[static_cast<int>(i)];
    power[i][0] = 1;
    for (std::size_t k = 1; k < 6; ++k) {
      power[i][k] = t * power[i][k - 1];
      slope[i][k] = static_cast<double>(k) * power[i][k - 1];
      bend[i][k] = static_cast<double>(k) * slope[i][k - 1];
    }
  }
  JetTerms sum;
  const std::size_t count = jet_terms_of_order(std::min(jet.order, degree - 1));
  for (std::size_t i = 0; i < count; ++i) {
    const double e = jet.coefficients[i];
    const auto [ia, ib, ic] = exponents[i];
    const auto a = static_cast<std::size_t>(ia), b = static_cast<std::size_t>(ib),
               c = static_cast<std::size_t>(ic);
    const double x = power[0][a], y = power[1][b], z = power[2][c];
    const double dx = slope[0][a], dy = slope[1][b], dz = slope[2][c];
    sum.energy += e * x * y * z;
    sum.gradient += e * Vec3(dx * y * z, x * dy * z, x * y * dz);
    sum.hessian(0, 0) += e * bend[0][a] * y * z;
    sum.hessian(1, 1) += e * x * bend[1][b] * z;
    sum.hessian(2, 2) += e * x * y * bend[2][c];
    sum.hessian(0, 1) += e * dx * dy * z;
    sum.hessian(0, 2) += e * dx * y * dz;
    sum.hessian(1, 2) += e * x * dy * dz;
  }
  sum.hessian(1, 0) = sum.hessian(0, 1);
  sum.hessian(2, 0) = sum.hessian(0, 2);
  sum.hessian(2, 1) = sum.hessian(1, 2);
  return sum;
}

}  // namespace forefeel
