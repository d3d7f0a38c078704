#include "scheduling/placement/placement_energy.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

constexpr int functionals = 9;
constexpr int order[functionals] = {1, 1, 1, 2, 2, 2, 2, 2, 2};
constexpr int axis[functionals][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

// Derivatives of r^m: phi_k = (1/r d/dr)^k r^m, k = 0 .. 4.
struct Radial {
  double phi[5];
  Radial(double r2, int m) : phi{} {
    if (r2 == 0) return;
    double power = std::sqrt(r2);  // r^(m - 2 k), from k = 4 down
    for (int exponent = 1; exponent < m - 8; exponent += 2) power *= r2;
    for (int exponent = 1; exponent > m - 8; exponent -= 2) power /= r2;
    double factor = double(m) * (m - 2) * (m - 4) * (m - 6);
    for (int k = 4; k >= 0; --k) {
      phi[k] = factor * power;
      power *= r2;
      if (k > 0) factor /= m - 2 * (k - 1);
    }
  }
};

double same(int a, int b) {
  return a == b ? 1.0 : 0.0;
}

double second(const Radial& p, const Vec3& d, int i, int j) {
  return p.phi[2] * d[i] * d[j] + p.phi[1] * same(i, j);
}
double third(const Radial& p, const Vec3& d, int i, int j, int k) {
  return p.phi[3] * d[i] * d[j] * d[k] +
         p.phi[2] * (same(i, j) * d[k] + same(i, k) * d[j] + same(j, k) * d[i]);
}
double fourth(const Radial& p, const Vec3& d, int i, int j, int k, int l) {
  return p.phi[4] * d[i] * d[j] * d[k] * d[l] +
         p.phi[3] * (same(i, j) * d[k] * d[l] + same(i, k) * d[j] * d[l] + same(i, l) * d[j] * d[k] +
                     same(j, k) * d[i] * d[l] + same(j, l) * d[i] * d[k] + same(k, l) * d[i] * d[j]) +
         p.phi[2] * (same(i, j) * same(k, l) + same(i, k) * same(j, l) + same(i, l) * same(j, k));
}

// Functional a at y, functional b at y_i, d = y - y_i: each derivative at y_i changes the sign.
double entry(const Radial& p, const Vec3& d, int a, int b) {
  const int i = axis[a][0], j = axis[a][1], k = axis[b][0], l = axis[b][1];
  if (order[a] == 1) return order[b] == 1 ? -second(p, d, i, k) : third(p, d, i, k, l);
  return order[b] == 1 ? -third(p, d, i, j, k) : fourth(p, d, i, j, k, l);
}

// Functional a of the monomial.
double of_monomial(const Vec3& y, std::array<int, 3> e, int a) {
  double factor = 1;
  for (int n = 0; n < order[a]; ++n) {
    int& exponent = e[static_cast<std::size_t>(axis[a][n])];
    factor *= exponent;
    if (factor == 0) return 0;
    --exponent;
  }
  for (int c = 0; c < 3; ++c)
    for (int n = 0; n < e[static_cast<std::size_t>(c)]; ++n) factor *= y[c];
  return factor;
}

std::vector<std::array<int, 3>> monomials(int degree, const std::array<bool, 3>& flat) {
  std::vector<std::array<int, 3>> all;
  for (int total = 1; total <= degree; ++total)
    for (int i = total; i >= 0; --i)
      for (int j = total - i; j >= 0; --j) {
        const std::array<int, 3> e{i, j, total - i - j};
        bool keep = true;
        for (std::size_t c = 0; c < 3; ++c) keep = keep && !(flat[c] && e[c] > 2);
        if (keep) all.push_back(e);
      }
  return all;
}

}  // namespace

std::shared_ptr<const EnergyInterpolant> EnergyInterpolant::fit(std::span<const State* const> states,
                                                                int degree, const std::array<bool, 3>& flat) {
  const auto n = static_cast<Eigen::Index>(states.size());
  if (n == 0) return nullptr;
  auto result = std::make_shared<EnergyInterpolant>();
  EnergyInterpolant& e = *result;
  for (const State* s : states) {
    if (!s->has_stiffness() || !s->force.allFinite()) return nullptr;
    e.centre_ += s->at / static_cast<double>(n);
  }
  e.scale_ = 0;
  for (const State* s : states) e.scale_ = std::max(e.scale_, (s->at - e.centre_).norm());
  if (!(e.scale_ > 0)) return nullptr;
  e.power_ = 2 * degree + 1;
  e.monomials_ = monomials(degree, flat);
  const auto terms = static_cast<Eigen::Index>(e.monomials_.size()), rows = functionals * n;
  if (rows < terms) return nullptr;

  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows + terms, rows + terms);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(rows + terms);
  for (const State* s : states) e.at_.push_back((s->at - e.centre_) / e.scale_);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const State& s = *states[at];
    for (int a = 0; a < functionals; ++a) {
      const Eigen::Index row = functionals * i + a;
      const int p = axis[a][0], q = axis[a][1];
      right[row] = order[a] == 1 ? -s.force[p] * e.scale_
                                 : 0.5 * (s.stiffness(p, q) + s.stiffness(q, p)) * e.scale_ * e.scale_;
      for (Eigen::Index t = 0; t < terms; ++t)
        matrix(row, rows + t) = of_monomial(e.at_[at], e.monomials_[static_cast<std::size_t>(t)], a);
    }
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Vec3 d = e.at_[at] - e.at_[static_cast<std::size_t>(j)];
      const Radial radial(d.squaredNorm(), e.power_);
      for (int a = 0; a < functionals; ++a)
        for (int b = 0; b < functionals; ++b)
          matrix(functionals * i + a, functionals * j + b) =
              matrix(functionals * j + b, functionals * i + a) = entry(radial, d, a, b);
    }
  }
  matrix.bottomLeftCorner(terms, rows) = matrix.topRightCorner(rows, terms).transpose();
  if (rank_of(matrix.topRightCorner(rows, terms), 1e-7) < terms) return nullptr;
  const Eigen::VectorXd solution = solved(matrix, right);
  if (!solution.allFinite()) return nullptr;
  e.weights_ = Eigen::Map<const Eigen::MatrixXd>(solution.data(), functionals, n);
  e.polynomial_ = solution.tail(terms);
  return result;
}

Vec3 EnergyInterpolant::force(const Vec3& x) const {
  const Vec3 y = (x - centre_) / scale_;
  Vec3 slope = Vec3::Zero();
  for (std::size_t i = 0; i < at_.size(); ++i) {
    const Vec3 d = y - at_[i];
    const Radial p(d.squaredNorm(), power_);
    const auto w = weights_.col(static_cast<Eigen::Index>(i));
    Mat3 b;
    b << w[3], 0.5 * w[6], 0.5 * w[7], 0.5 * w[6], w[4], 0.5 * w[8], 0.5 * w[7], 0.5 * w[8], w[5];
    const Vec3 a = w.head<3>(), bd = b * d;
    // -H a + (grad H : B), H the second derivatives of r^m
    slope -= p.phi[2] * d * d.dot(a) + p.phi[1] * a;
    slope += (p.phi[3] * d.dot(bd) + p.phi[2] * b.trace()) * d + 2 * p.phi[2] * bd;
  }
  for (std::size_t t = 0; t < monomials_.size(); ++t)
    for (int c = 0; c < 3; ++c)
      slope[c] += polynomial_[static_cast<Eigen::Index>(t)] * of_monomial(y, monomials_[t], c);
  return -slope / scale_;
}

}  // namespace forefeel
