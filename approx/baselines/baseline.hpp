#pragma once
// What `forefeel bench approx` compares with, compiled once for each instruction set and chosen like our own
// loops:
//   the saddle system of paper Eq. 2 assembled whole and solved by Eigen's PartialPivLU, three right-hand
//   sides the sum of paper Eq. 1 (r^3, linear p) centre by centre at -O2, no vectors

#include <cstddef>
#include <span>

#include "approx/rbf_fit.hpp"

namespace forefeel {

// r^3 with linear p on force, or r^5 with quadratic p on force and stiffness. Work space is kept between
// calls.
class LuRefit {
 public:
  LuRefit(std::size_t states, bool hermite_quintic);
  ~LuRefit();
  LuRefit(const LuRefit&) = delete;
  LuRefit& operator=(const LuRefit&) = delete;
  // Fits; returns the first coefficient, so that nothing is optimised away.
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

}  // namespace forefeel
