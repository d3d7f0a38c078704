#pragma once
// The difference of a fine body's energy jet at rest and a coarse body's own, added to everything the coarse body
// answers: two bodies of one shape, with the same contact, have rest jets J_f and J_c, and the body that is answered
// for has
//   E(x) = E_c(x) + dE(s(x)),   dE(x) = J_f(x) - J_c(x) = 1/2 x^T (K_f - K_c) x + degrees 3 to 5      [J]
// so f = -dE/dx and K = d2E/dx2 stay consistent and K symmetric. A polynomial grows without bound; so its argument
// saturates:
//   s(x) = x h(t) / t,  t = |x| / rho,  h(t) = t to t = 0.8,  then 0.8 + 0.2 z / (1 + z^4)^(1/4), z = (t - 0.8) / 0.2
// |s| < rho, and s has four continuous derivatives. 0.8 rho [m] is the distance at which, in the root mean square over
// directions, the last degree of the force -dE/dd reaches 3 % of |K_f d|, the one before it 20 % or the one before that
// 100 %; infinite if none differs. Measured on phantoms, linear bodies with the jet of a quadratic body of 1,800
// elements against that body solved: within it the force errs by 0.5 % (p50), and by 3 % but in creases, where no
// series holds; where dE saturates, by the 10 to 50 % of the linear body alone.

#include <array>
#include <limits>
#include <optional>
#include <string>

#include "geometry/states/energy_jet.hpp"

namespace forefeel {

struct RestJet {
  Mat3 stiffness = Mat3::Zero();  // K [N/m]
  EnergyJet jet;                  // of order 4
};

// A second fine body, of larger elements: what refinement still changes.
struct SecondFine {
  RestJet rest;
  double ratio = 2;  // of the edges, this body's over the fine body's, (N_fine / N)^(1/3)
};

// Relative error of a force, and an interval that holds it.
struct ForceError {
  double error = 0, low = 0, high = 0;
};

class FineJet {
 public:
  static constexpr double trusted_share = 0.8;  // of rho, to which s(x) = x
  // fine_body: what the fine body is, in words and hashes; part of the identity of what is answered.
  FineJet(const RestJet& fine, const RestJet& coarse, std::string fine_body,
          const std::optional<SecondFine>& second = {});

  JetTerms at(const Vec3& x) const;  // dE(s(x)), gradient and Hessian
  // Adds the Taylor coefficients of dE(s(x + d)) in d to a state's jet, those that its order has.
  void add_to(EnergyJet& jet, const Vec3& x) const;
  // Error of the force f at x that is left with the fine body, by Richardson extrapolation from the second one: with
  // c = |df/dlevel| / |f|, the change of the force between the two, errors that fall as h^p leave c / (r^p - 1).
  // error: p = 2.7; low: p = 4.5, faster than smooth solutions converge; high: p = 1.8, as beside a rim, and half of
  // what the last degree of dE adds. The exponents were fitted to two phantoms with fine bodies of 900 and 1,800
  // elements (tests/bench/interval_of_truth.py). nullopt without a second fine body, at rest, and beyond 0.8 rho, where
  // the argument saturates and nothing is claimed.
  std::optional<ForceError> error_left(const Vec3& x, const Vec3& force) const;
  double radius() const { return radius_; }                        // rho [m]
  const Mat3& stiffness() const { return difference_.stiffness; }  // K_f - K_c
  const std::string& fine_body() const { return fine_body_; }

 private:
  void add_shifted(EnergyJet& jet, const Vec3& x) const;

  RestJet difference_;
  std::optional<SecondFine> change_;  // J_f minus the second fine body's
  double radius_ = std::numeric_limits<double>::infinity();
  std::string fine_body_;
};

}  // namespace forefeel
