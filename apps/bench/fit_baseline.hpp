#pragma once
// Baselines of `forefeel bench approx`, compiled once per instruction set and chosen like the loops of the
// models:
//   LuRefit          the saddle system of paper Eq. 2, assembled whole and solved by Eigen's PartialPivLU
//   scalar_evaluate  the sum of paper Eq. 1 (r^3, linear p; or r^5 with stiffness), centre by centre at -O2,
//                    without vectors

#include <cstddef>
#include <span>

#include "approx/model/rbf_fit.hpp"

namespace forefeel {

// Refit of r^3 with linear p on force, or of r^5 with quadratic p on force and stiffness. The work space is kept
// between calls.
class LuRefit {
 public:
  LuRefit(std::size_t states, bool hermite_quintic);
  ~LuRefit();
  LuRefit(const LuRefit&) = delete;
  LuRefit& operator=(const LuRefit&) = delete;
  // Solves for the coefficients. Returns the first one, so that the compiler does not remove the work.
  double refit(std::span<const Sample> samples);

 private:
  void* work_;
  std::size_t states_;
  bool hermite_;
  std::vector<double> positions_, values_;
};

// positions: x y z of each centre, coefficients: 3 per centre then 3 x 4 of p.
void scalar_evaluate(std::size_t n, const double* positions, const double* coefficients, const double x[3],
                     double f[3]);
// r^5 on force and stiffness, quadratic p. centres: n x 15, position, coefficients of the force, of the
// stiffness (3 x 3); polynomial: 3 x 10 over 1 x y z xx yy zz xy xz yz.
void scalar_evaluate_hermite(std::size_t n, const double* centres, const double* polynomial,
                             const double x[3], double f[3]);

}  // namespace forefeel
