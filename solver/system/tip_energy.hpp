#pragma once
// The fine jet dE(x) of a body (solver/body/fine_jet.hpp) as an energy of the contact's local node, whose displacement
// is x: force, stiffness and energy of every solve contain it, and no free node feels it.

#include <cstdint>
#include <memory>

#include "solver/body/fine_jet.hpp"

namespace forefeel {

struct TipEnergy {
  std::shared_ptr<const FineJet> jet;  // null: none
  std::int64_t node = 0, block = 0;    // the contact's local node and its own block of the pattern

  // As the loops of ElementGroups, for local vectors and eight side by side; add_gradient returns dE.
  double add_gradient(const double* u, double* r) const;
  void add_hessian(const double* u, double* blocks) const;
  void add_gradient_lanes(const double* u, double* r, double* energy) const;
  void add_product(std::int64_t stride, const double* u, const double* d, double* y) const;
  void add_product_lanes(std::int64_t stride, const double* u, const double* d, double* y) const;
};

}  // namespace forefeel
