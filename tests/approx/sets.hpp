#pragma once
// Fields and sets of states that the tests of approx share, and an oracle: the saddle system of paper Eq. 2,
// solved in long double by an LU with complete pivoting.

#include <Eigen/LU>
#include <random>
#include <string>
#include <vector>

#include "approx/model/updater.hpp"

namespace forefeel::test {

// A smooth stiffening conservative field: W = a/2 |x|^2 + b/4 |x|^4 + shear, f = -grad W, K = -df/dx.
inline State field_state(const Vec3& at) {
  const double a = 40, b = 2e4;
  Mat3 coupling;
  coupling << 1.0, 0.2, -0.1, 0.2, 1.4, 0.15, -0.1, 0.15, 0.8;
  const Vec3 u = coupling * at;
  const double s = std::sin(30 * u[0]), c = std::cos(30 * u[0]);
  State state;
  state.at = at;
  // W = a/2 x.Cx + b/4 (x.x)^2 + 0.02 (1 - cos 30 u0)
  state.force = -(a * u + b * at.squaredNorm() * at + 0.6 * s * coupling.row(0).transpose());
  state.stiffness = a * coupling + b * (at.squaredNorm() * Mat3::Identity() + 2 * at * at.transpose()) +
                    18 * c * coupling.row(0).transpose() * coupling.row(0);
  state.solve.status = SolveStatus::converged;
  return state;
}

// k of the kernel r^k that the model uses; 0: the tangent alone.
inline int power_of(const Model& model) {
  if (model.is_tangent()) return 0;
  return model.kernel() == Kernel::linear ? 1 : model.kernel() == Kernel::cubic ? 3 : 5;
}

inline std::vector<State> states_at(const std::vector<Vec3>& points) {
  std::vector<State> states;
  for (const auto& p : points) states.push_back(field_state(p));
  return states;
}

inline std::vector<Vec3> random_points(std::size_t n, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-size, size);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < n; ++i) points.emplace_back(unit(random), unit(random), unit(random));
  return points;
}

inline std::vector<Vec3> lattice_points(int half, double h) {
  std::vector<Vec3> points;
  for (int i = -half; i <= half; ++i)
    for (int j = -half; j <= half; ++j)
      for (int k = -half; k <= half; ++k) points.emplace_back(i * h, j * h, k * h);
  return points;
}

// A pool of 3 n states: lattice, near-duplicate (pairs 1e-6 apart), coplanar (within 1e-4), collinear (within
// 1e-4), clustered (within 1e-3); lengths relative to a size of 3 cm.
inline std::vector<Vec3> hard_set(const std::string& kind, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const double size = 0.03;
  std::vector<Vec3> points;
  if (kind == "lattice") {
    int half = 1;
    while (std::size_t(2 * half + 1) * std::size_t(2 * half + 1) * std::size_t(2 * half + 1) < count) ++half;
    points = lattice_points(half, size / half);
    std::shuffle(points.begin(), points.end(), random);
    points.resize(count);
    return points;
  }
  const auto any = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  std::vector<Vec3> centres;
  for (int c = 0; c < 12; ++c) centres.push_back(any());
  while (points.size() < count) {
    Vec3 p = any();
    if (kind == "near-duplicate" && points.size() % 2 == 1) p = points.back() / size + 1e-6 * any();
    if (kind == "coplanar") p = Vec3(p[0], p[1], 0.3 * p[0] - 0.2 * p[1] + 1e-4 * p[2]);
    if (kind == "collinear") p = Vec3(p[0], 0.4 * p[0] + 1e-4 * p[1], -0.3 * p[0] + 1e-4 * p[2]);
    if (kind == "clustered") p = centres[points.size() % centres.size()] + 1e-3 * p;
    points.push_back(size * p);
  }
  return points;
}

using Real = long double;
using RealMatrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

// The interpolant of the states in long double, with the kernel and degree of the model under test.
class Judge {
 public:
  Judge(const std::vector<State>& states, int power, int degree, bool hermite)
      : Judge(states, power, degree, hermite, 0, states) {}

  // With a ridge on the diagonal, centre and scale being those of `frame`.
  Judge(const std::vector<State>& states, int power, int degree, bool hermite, double ridge,
        const std::vector<State>& frame)
      : states_(states), power_(power), rows_(hermite ? 4 : 1) {
    for (const auto& s : frame) centre_ += s.at / double(frame.size());
    for (const auto& s : frame) scale_ = std::max(scale_, (s.at - centre_).norm());
    if (scale_ == 0) scale_ = 1;
    const Eigen::Index m = Eigen::Index(states.size()) * rows_, q = degree == 0 ? 1 : degree == 1 ? 4 : 10;
    RealMatrix a = RealMatrix::Zero(m + q, m + q), b = RealMatrix::Zero(m + q, 3);
    for (Eigen::Index i = 0; i < m; ++i) {
      const auto& s = states[std::size_t(i / rows_)];
      const int di = int(i % rows_);
      const auto yi = scaled(s.at);
      for (Eigen::Index j = 0; j < m; ++j)
        a(i, j) = pair(yi, di, scaled(states[std::size_t(j / rows_)].at), int(j % rows_));
      a(i, i) += power == 3 ? ridge : -ridge;
      for (int t = 0; t < q; ++t) a(i, m + t) = a(m + t, i) = term(t, yi, di);
      for (int c = 0; c < 3; ++c)
        b(i, c) = di == 0 ? Real(s.force[c]) : -Real(s.stiffness(c, di - 1)) * Real(scale_);
    }
    solution_ = a.fullPivLu().solve(b);
  }

  Vec3 force(const Vec3& x) const {
    const auto y = scaled(x);
    Eigen::Matrix<Real, 3, 1> f = Eigen::Matrix<Real, 3, 1>::Zero();
    const auto m = Eigen::Index(states_.size()) * rows_;
    for (Eigen::Index j = 0; j < m; ++j)
      f += pair(y, 0, scaled(states_[std::size_t(j / rows_)].at), int(j % rows_)) *
           solution_.row(j).transpose();
    for (Eigen::Index t = m; t < solution_.rows(); ++t)
      f += term(int(t - m), y, 0) * solution_.row(t).transpose();
    return f.cast<double>();
  }

 private:
  using Point = Eigen::Matrix<Real, 3, 1>;
  Point scaled(const Vec3& x) const { return (x - centre_).cast<Real>() / Real(scale_); }

  Real pair(const Point& a, int da, const Point& b, int db) const {
    const Point d = a - b;
    const Real r = std::sqrt(d.squaredNorm()), k = power_;
    const auto pow_r = [&](int e) {
      return e >= 0 ? std::pow(r, Real(e)) : r > 0 ? std::pow(r, Real(e)) : Real(0);
    };
    if (da == 0 && db == 0) return pow_r(power_);
    const Real first = k * pow_r(power_ - 2);
    if (da == 0) return -first * d[db - 1];
    if (db == 0) return first * d[da - 1];
    const Real second = k * (k - 2) * pow_r(power_ - 4);
    return -(da == db ? first : Real(0)) - second * d[da - 1] * d[db - 1];
  }

  Real term(int t, const Point& y, int derivative) const {
    static constexpr int exponent[10][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0},
                                            {0, 2, 0}, {0, 0, 2}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
    Real value = 1;
    for (int d = 0; d < 3; ++d) {
      const int e = exponent[t][d];
      if (derivative == d + 1)
        value *= e == 0 ? Real(0) : e == 1 ? Real(1) : 2 * y[d];
      else
        for (int i = 0; i < e; ++i) value *= y[d];
    }
    return value;
  }

  std::vector<State> states_;
  int power_;
  Eigen::Index rows_;
  Vec3 centre_ = Vec3::Zero();
  double scale_ = 0;
  RealMatrix solution_;
};

// The kinds of fit that every test of fits goes through.
struct FitCase {
  Kernel kernel;
  Data data;
};
inline const std::vector<FitCase> fit_cases = {{Kernel::linear, Data::force},
                                               {Kernel::cubic, Data::force},
                                               {Kernel::quintic, Data::force},
                                               {Kernel::cubic, Data::force_and_stiffness},
                                               {Kernel::quintic, Data::force_and_stiffness}};

}  // namespace forefeel::test
