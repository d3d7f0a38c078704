#pragma once
// Energy jets of an equilibrium (x_0, u_0) from the factor of its tangent A = d2E/du2, by the 2n + 1 theorem:
//   u_1 = U d                      the tangent du/dx
//   q   = 1/2 W_3[u_1, u_1, .]     A u_2 = -q
//   E_3 = 1/3 q . u_1
//   E_4 = [t^4] W(u_0 + t u_1) - 1/2 q^T A^{-1} q
//   E_5 = [t^5] W(u_0 + t u_1 + t^2 u_2)
// W_k: k-th derivative of the stored energy; [t^k]: Taylor coefficient. Order 2 (of the force) needs no further solve,
// order 3 six forward halves of solves, order 4 six solves. The Taylor coefficients are polynomials in d, made at each
// point of the material (solver/kernels/law_forms.hpp), exact to rounding. A pad's springs are linear: they are in A
// alone. The equilibrium must be exact: with a residual of 1e-9 N degrees 3 and 4 are off by 1e-9,
// with 6e-5 N by 2e-4 of their size.
//
// Material limit (EnergyJet::limit): the least |d|, over the limit directions below and their opposites, at which the
// jet's own displacement u_0 + U d + V[d, d] (order 2 and 3: without V) takes an element's least principal stretch
// below the limit of its law (LawEntry::least_stretch). A force of the jet may belong to no equilibrium beyond it. A
// heuristic: it sees where the material softens or folds, not that the series has ended. Of paths that dip below the
// limit and come back only those that are below it at the end or half-way are seen.

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "geometry/common/types.hpp"
#include "geometry/states/energy_jet.hpp"
#include "solver/system/factorisation.hpp"

namespace forefeel {

// The axes, (1, +-0.6) and (0.6, +-1)-like pairs in the coordinate planes, and six inside.
inline constexpr std::size_t limit_direction_count = most_directions;
const std::array<double, 3 * limit_direction_count>& limit_directions();  // row by row
const std::array<double, limit_direction_count>& limit_lengths();

// What a jet needs of A: eight b in lanes become A^{-1} b, or U^-T b with A = U^T U (for order 3 alone).
struct JetSolves {
  std::function<void(double*)> whole, half;
};

// Work space of one body for one thread.
class JetMaker {
 public:
  explicit JetMaker(std::shared_ptr<const Discretisation> discretisation);

  // u: local vector of the equilibrium, tangent: U, three local vectors; factor: exact, of H(u). order: 2, 3 or 4.
  EnergyJet at(const std::vector<double>& u, const std::vector<double>& tangent, const Factorisation& factor,
               int order);
  // The same without a factor of A itself; the fine jet of the body does not count.
  EnergyJet at(const std::vector<double>& u, const std::vector<double>& tangent, const JetSolves& solves,
               int order);

 private:
  void curvature(const std::vector<double>& u, const std::vector<double>& tangent,
                 const JetDirections& directions);
  void set_third(const std::vector<double>& tangent, EnergyJet& jet) const;
  void add_product(const std::vector<double>& a, const std::vector<double>& b, double factor,
                   EnergyJet& jet) const;

  std::shared_ptr<const Discretisation> d_;
  std::vector<double> second_, right_;  // q, then half solves or V; q: (n+2) x 3 x 8
  std::vector<double> hardness_;        // of each group of elements (JetDirections)
};

}  // namespace forefeel
