#include "solver/body/fine_jet.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace forefeel {
namespace {

constexpr int most_degree = 5;

// A polynomial in d of degree 5 at most; products are truncated.
class Polynomial {
 public:
  static constexpr std::size_t size = 56;

  double& operator()(int a, int b, int c) { return terms_[index(a, b, c)]; }
  double operator()(int a, int b, int c) const { return terms_[index(a, b, c)]; }
  Polynomial& operator+=(const Polynomial& other) {
    for (std::size_t i = 0; i < size; ++i) terms_[i] += other.terms_[i];
    return *this;
  }
  friend Polynomial operator*(double factor, Polynomial p) {
    for (double& term : p.terms_) term *= factor;
    return p;
  }
  friend Polynomial operator*(const Polynomial& p, const Polynomial& q) {
    Polynomial product;
    for_each([&](int a, int b, int c) {
      const double left = p(a, b, c);
      if (left == 0) return;
      for_each([&](int i, int j, int k) { product(a + i, b + j, c + k) += left * q(i, j, k); },
               most_degree - a - b - c);
    });
    return product;
  }
  template <class Visit>
  static void for_each(const Visit& visit, int most = most_degree) {
    for (int degree = 0; degree <= most; ++degree)
      for (int a = degree; a >= 0; --a)
        for (int b = degree - a; b >= 0; --b) visit(a, b, degree - a - b);
  }

 private:
  static std::size_t index(int a, int b, int c) {
    const int degree = a + b + c, below = degree - a;
    return static_cast<std::size_t>(degree * (degree + 1) * (degree + 2) / 6 + below * (below + 1) / 2 + c);
  }
  std::array<double, size> terms_{};
};

// h(t) / t and its derivatives by q = t^2, from truncated series in q.
class Saturation {
 public:
  using Series = std::array<double, most_degree + 1>;

  static Series at(double q) {
    Series one{};
    one[0] = 1;
    const double t = std::sqrt(q);
    if (t <= FineJet::trusted_share) return one;
    Series shifted{};
    shifted[0] = q, shifted[1] = 1;
    const Series root = power(shifted, 0.5);
    Series z = root;
    z[0] -= FineJet::trusted_share;
    for (double& term : z) term /= 1 - FineJet::trusted_share;
    const Series z2 = product(z, z);
    Series inner = product(z2, z2);
    inner[0] += 1;
    Series h = product(z, power(inner, -0.25));
    for (double& term : h) term *= 1 - FineJet::trusted_share;
    h[0] += FineJet::trusted_share;
    return product(h, power(shifted, -0.5));
  }

 private:
  static Series product(const Series& a, const Series& b) {
    Series c{};
    for (std::size_t i = 0; i < a.size(); ++i)
      for (std::size_t j = 0; i + j < a.size(); ++j) c[i + j] += a[i] * b[j];
    return c;
  }
  // J. C. P. Miller's recursion for a^e (Henrici, Applied and Computational Complex Analysis, 1974, 1.6).
  static Series power(const Series& a, double e) {
    Series p{};
    p[0] = std::pow(a[0], e);
    for (std::size_t k = 1; k < a.size(); ++k) {
      double sum = 0;
      for (std::size_t i = 1; i <= k; ++i)
        sum += (e * static_cast<double>(i) - static_cast<double>(k - i)) * a[i] * p[k - i];
      p[k] = sum / (static_cast<double>(k) * a[0]);
    }
    return p;
  }
};

// Directions over the half sphere, evenly (Fibonacci's lattice); opposite ones have forces of the same size.
std::vector<Vec3> sphere_directions() {
  constexpr int count = 400;
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Vec3> list;
  for (int i = 0; i < count; ++i) {
    const double z = (i + 0.5) / count, side = std::sqrt(1 - z * z);
    list.emplace_back(side * std::cos(turn * i), side * std::sin(turn * i), z);
  }
  return list;
}

// Root mean square, over directions, of |force of this degree of dE| / |K_f d| at |d| = 1.
double share_of(const RestJet& difference, const Mat3& stiffness, int degree) {
  double sum = 0;
  const std::vector<Vec3> ways = sphere_directions();
  for (const Vec3& way : ways)
    sum += (jet_terms(difference.jet, way, degree).gradient -
            jet_terms(difference.jet, way, degree - 1).gradient)
               .squaredNorm() /
           (stiffness * way).squaredNorm();
  return std::sqrt(sum / static_cast<double>(ways.size()));
}

// 0.8 rho: where the first degree reaches its share.
double trusted_to(const RestJet& difference, const Mat3& stiffness) {
  return std::min({1.0 / share_of(difference, stiffness, 3),
                   std::sqrt(0.2 / share_of(difference, stiffness, 4)),
                   std::cbrt(0.03 / share_of(difference, stiffness, 5))});
}

RestJet between(RestJet a, const RestJet& b) {
  a.stiffness -= b.stiffness;
  a.stiffness = 0.5 * (a.stiffness + a.stiffness.transpose()).eval();
  a.jet.order = most_jet_order;
  for (std::size_t i = 0; i < jet_size; ++i) a.jet.coefficients[i] -= b.jet.coefficients[i];
  return a;
}

}  // namespace

FineJet::FineJet(const RestJet& fine, const RestJet& coarse, std::string fine_body, Refine refine)
    : fine_(fine),
      difference_(between(fine, coarse)),
      refine_(std::move(refine)),
      fine_body_(std::move(fine_body)) {
  radius_ = trusted_to(difference_, fine.stiffness) / trusted_share;
}

const std::optional<Refinement>& FineJet::refinement() const {
  std::call_once(refined_, [this] {
    if (refine_) refinement_ = refine_();
  });
  return refinement_;
}

std::shared_ptr<const Body> FineJet::solved() const {
  return refinement() ? refinement()->solved : nullptr;
}

JetTerms FineJet::at(const Vec3& x) const {
  const auto polynomial = [&](const Vec3& s) {
    JetTerms terms = jet_terms(difference_.jet, s);
    terms.energy += 0.5 * s.dot(difference_.stiffness * s);
    terms.gradient += difference_.stiffness * s;
    terms.hessian += difference_.stiffness;
    return terms;
  };
  const double scale = 1 / (radius_ * radius_), q = scale * x.squaredNorm();
  if (!(q > FineJet::trusted_share * FineJet::trusted_share)) return polynomial(x);
  const Saturation::Series h = Saturation::at(q);
  const double value = h[0], slope = scale * h[1], bend = 2 * scale * scale * h[2];  // by |x|^2
  JetTerms terms = polynomial(value * x);
  const Mat3 along = x * x.transpose(), one = Mat3::Identity();
  const Mat3 change = value * one + 2 * slope * along;  // ds/dx
  const Vec3 g = terms.gradient;
  terms.gradient = change * g;
  terms.hessian = (change * terms.hessian * change + 2 * slope * (g * x.transpose() + x * g.transpose()) +
                   2 * slope * g.dot(x) * one + 4 * bend * g.dot(x) * along)
                      .eval();
  return terms;
}

std::optional<ForceError> FineJet::error_left(const Vec3& x, const Vec3& force,
                                              const Vec3& solved_force) const {
  const double size = force.norm();
  if (!(size > 0) || !(x.norm() > 0) || x.norm() > trusted_share * radius_ || !refinement()) return {};
  const Refinement& refined = *refinement();
  const auto more_than = [&](const RestJet& rest) -> Vec3 {
    return (fine_.stiffness - rest.stiffness) * x + jet_terms(fine_.jet, x).gradient -
           jet_terms(rest.jet, x).gradient;
  };
  const Vec3 degrees = force + more_than(refined.of_solved) - solved_force;
  const Vec3 mesh = -more_than(refined.finer) / (1 - std::pow(refined.ratio, -3.7));
  const double alike = std::pow(2 / refined.ratio, 1.75);
  const double error = (degrees + mesh).norm() / size, t = degrees.norm() / size,
               h = alike * mesh.norm() / size;
  return ForceError{error, std::max(0.0, error - 0.43 * h - 0.285 * t - 0.00065),
                    error + 0.38 * h + 0.475 * t + 0.00065};
}

// Where s(x) = x: each coefficient of degree 3 and above is a Taylor shift.
void FineJet::add_shifted(EnergyJet& jet, const Vec3& x) const {
  constexpr std::array<std::array<double, 6>, 6> choose{
      {{1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}, {1, 5, 10, 10, 5, 1}}};
  const auto times = [&](int i, int a) {
    return choose[static_cast<std::size_t>(i)][static_cast<std::size_t>(a)];
  };
  std::array<std::array<double, 3>, 3> power{};  // of each coordinate, 0 to 2
  for (std::size_t i = 0; i < 3; ++i)
    power[i] = {1, x[static_cast<int>(i)], x[static_cast<int>(i)] * x[static_cast<int>(i)]};
  Polynomial::for_each(
      [&](int a, int b, int c) {
        if (a + b + c < 3) return;
        double sum = 0;
        Polynomial::for_each(
            [&](int i, int j, int k) {
              sum += times(a + i, a) * times(b + j, b) * times(c + k, c) *
                     power[0][static_cast<std::size_t>(i)] * power[1][static_cast<std::size_t>(j)] *
                     power[2][static_cast<std::size_t>(k)] *
                     difference_.jet.coefficients[jet_index(a + i, b + j, c + k)];
            },
            most_degree - a - b - c);
        jet.coefficients[jet_index(a, b, c)] += sum;
      },
      jet.order + 1);
}

void FineJet::add_to(EnergyJet& jet, const Vec3& x) const {
  const double scale = 1 / (radius_ * radius_), q = scale * x.squaredNorm();
  if (!(q > trusted_share * trusted_share)) return add_shifted(jet, x);
  Polynomial change;  // of q
  for (int i = 0; i < 3; ++i) {
    change(i == 0, i == 1, i == 2) = 2 * scale * x[i];
    change(2 * (i == 0), 2 * (i == 1), 2 * (i == 2)) = scale;
  }
  Polynomial factor, power;  // h(t) / t in d
  power(0, 0, 0) = 1;
  for (const double term : Saturation::at(q)) {
    factor += term * power;
    power = power * change;
  }
  std::array<Polynomial, 3> s;  // s(x + d)
  for (int i = 0; i < 3; ++i) {
    Polynomial& component = s[static_cast<std::size_t>(i)];
    component(0, 0, 0) = x[i];
    component(i == 0, i == 1, i == 2) = 1;
    component = component * factor;
  }
  const auto coefficient = [&](int a, int b, int c) {
    if (a + b + c >= 3) return difference_.jet.coefficients[jet_index(a, b, c)];
    if (a + b + c < 2) return 0.0;
    const int i = a > 0 ? 0 : b > 0 ? 1 : 2, k = c > 0 ? 2 : b > 0 ? 1 : 0;
    return (i == k ? 0.5 : 1.0) * difference_.stiffness(i, k);
  };
  Polynomial sum;  // Horner's scheme in s_x, s_y, s_z
  for (int a = most_degree; a >= 0; --a) {
    Polynomial in_y;
    for (int b = most_degree - a; b >= 0; --b) {
      Polynomial in_z;
      for (int c = most_degree - a - b; c >= 0; --c) {
        in_z = in_z * s[2];
        in_z(0, 0, 0) += coefficient(a, b, c);
      }
      in_y = in_y * s[1];
      in_y += in_z;
    }
    sum = sum * s[0];
    sum += in_y;
  }
  Polynomial::for_each(
      [&](int a, int b, int c) {
        if (a + b + c >= 3) jet.coefficients[jet_index(a, b, c)] += sum(a, b, c);
      },
      jet.order + 1);
}

}  // namespace forefeel
