#pragma once
// The baseline of a fit: the saddle system of paper Eq. 2, assembled whole and solved by Eigen's PartialPivLU. Compiled
// once per instruction set and chosen like the loops of the models.

#include <cstddef>
#include <span>
#include <vector>

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

}  // namespace forefeel
