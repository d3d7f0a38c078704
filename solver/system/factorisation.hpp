#pragma once
// Factor of H = d2W/du2 with the free nodes (f) eliminated and the contact (c) last:
//   H = [H_ff H_fc; H_cf H_cc] = U^T U, except for the last 3 x 3 corner, which becomes
//   K = H_cc - H_cf H_ff^{-1} H_fc     the condensed stiffness [N/m], symmetric by construction
// The tangent du/dx = -H_ff^{-1} H_fc needs a backward substitution only. Multifrontal (Duff, Reid 1983;
// kernels.hpp).

#include <memory>

#include "solver/system/discretisation.hpp"

namespace forefeel {

struct FactorCost {
  double flops = 0;  // multiplications of one factorisation
  std::int64_t factor_bytes = 0, stack_bytes = 0;
};

// Precision of the factor. single: half the time and memory; an iteration with H itself must correct its relative
// error, about 1e-7 times the condition number of H.
enum class Precision { exact, single };

// The discretisation of a body with the symbolic analysis of its factors of one precision, for several solvers.
std::shared_ptr<const Discretisation> analyse(const Body& body, Precision precision = Precision::exact);
// Cost of a factor with the discretisation's symbolic analysis, which it must have; nothing is factorised.
FactorCost cost_of_factor(const Discretisation& discretisation);

class Factorisation {
 public:
  // Does the symbolic analysis unless the discretisation has one of this precision. It must outlive this.
  explicit Factorisation(const Discretisation& discretisation, Precision precision = Precision::exact);
  ~Factorisation();
  Factorisation(Factorisation&&) noexcept;

  // blocks: values of H by Discretisation::pattern. False unless H_ff is positive definite; after false, call
  // nothing below.
  bool compute(const double* blocks);
  void solve(double* b) const;  // b: local vector; its free part becomes H_ff^{-1} b, the contact's part 0
  // The same for eight right-hand sides side by side, up to three times, so many numbers apart.
  void solve_lanes(double* b, std::size_t fields = 1, std::int64_t stride = 0) const;
  // H_ff = U^T U: eight b become U^-T b, whose squares sum to b^T H_ff^{-1} b; the contact's part 0.
  void half_solve_lanes(double* b) const;
  Mat3 stiffness() const;         // K [N/m]
  void tangent(double* v) const;  // three local vectors du/dx_c one after the other; contact = I, clamp = 0
  Precision precision() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
