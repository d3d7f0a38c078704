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
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "geometry/states/energy_jet.hpp"

namespace forefeel {

struct Body;

struct RestJet {
  Mat3 stiffness = Mat3::Zero();  // K [N/m]
  EnergyJet jet;                  // of order 4
};

// What an error of the fine body is measured by: a finer body, for what refinement still changes, and a body of
// quadratic elements that is small enough to be solved, for the degrees that dE leaves out.
struct Refinement {
  RestJet finer;
  double ratio =
      2;  // r of the edges, the fine body's over the finer one's, (N / N_fine)^(1/3); below 1: larger elements
  std::shared_ptr<const Body> solved;  // without a fine body
  RestJet of_solved;
};

// Relative error of a force, and an interval that holds it.
struct ForceError {
  double error = 0, low = 0, high = 0;
};

class FineJet {
 public:
  static constexpr double trusted_share = 0.8;  // of rho, to which s(x) = x
  using Refine = std::function<std::optional<Refinement>()>;
  // fine_body: what the fine body is, in words and hashes; part of the identity of what is answered. refine: called at
  // most once, by the first who asks for an error; must not throw.
  FineJet(const RestJet& fine, const RestJet& coarse, std::string fine_body, Refine refine = {});

  JetTerms at(const Vec3& x) const;  // dE(s(x)), gradient and Hessian
  // Adds the Taylor coefficients of dE(s(x + d)) in d to a state's jet, those that its order has.
  void add_to(EnergyJet& jet, const Vec3& x) const;
  // The body whose force at x error_left() wants; null without one. Any thread may ask; the first waits for it.
  std::shared_ptr<const Body> solved() const;
  // Error of the force f at x that is left with the fine body, f_q the force of solved() at x. With gradients at x,
  //   e = t + h,  t = f + grad(J_f - J_q) - f_q,  h = -grad(J_f - J_finer) / (1 - r^-3.7)      [N]
  // t: what the degrees beyond 5 of the difference of quadratic and linear elements would change; h: what refinement
  // would, if errors fall as edges^3.7. error: |e| / |f|. low and high: |e| less 0.43 g |h| + 0.285 |t|, more by
  // 0.38 g |h| + 0.475 |t|, and 0.00065 |f| each; g = (2 / r)^1.75, as a mesh that is hardly finer has much the same
  // errors. The numbers are fitted to seven bodies (tests/bench/interval_of_truth.py). nullopt without a refinement, at
  // rest, and beyond 0.8 rho, where the argument saturates and nothing is claimed.
  std::optional<ForceError> error_left(const Vec3& x, const Vec3& force, const Vec3& solved_force) const;
  double radius() const { return radius_; }                        // rho [m]
  const Mat3& stiffness() const { return difference_.stiffness; }  // K_f - K_c
  const std::string& fine_body() const { return fine_body_; }

 private:
  void add_shifted(EnergyJet& jet, const Vec3& x) const;
  const std::optional<Refinement>& refinement() const;

  RestJet fine_;
  RestJet difference_;
  Refine refine_;
  mutable std::once_flag refined_;
  mutable std::optional<Refinement> refinement_;
  double radius_ = std::numeric_limits<double>::infinity();
  std::string fine_body_;
};

}  // namespace forefeel
