#include "apps/bench/scalar_evaluate.hpp"

#include "geometry/common/instruction_set.hpp"

namespace forefeel {

FOREFEEL_IN_EACH_SET(void scalar_sum(std::size_t, const double*, const double*, const double*, double*);
                     void scalar_hermite_sum(std::size_t, const double*, const double*, const double*,
                                             double*);)

void scalar_evaluate(std::size_t n, const double* positions, const double* coefficients, const double x[3],
                     double f[3]) {
  static const auto sum = FOREFEEL_CHOSEN(scalar_sum);
  sum(n, positions, coefficients, x, f);
}
void scalar_evaluate_hermite(std::size_t n, const double* centres, const double* polynomial,
                             const double x[3], double f[3]) {
  static const auto sum = FOREFEEL_CHOSEN(scalar_hermite_sum);
  sum(n, centres, polynomial, x, f);
}

}  // namespace forefeel
