#pragma once
// The field of sites for a moving hand: on each facet K(s), the mean normal and the coefficients of degrees 3 to 5 of
// E(s, x) in x are cubic polynomials of s, through their exact values at ten places (corners, thirds of the edges, the
// middle), so
//   E(s, x) = 1/2 x^T K(s) x + sum_j c_j(s) m_j(x),   dE/ds = 1/2 x^T K'(s) x + sum_j c_j'(s) m_j(x)
// are exact derivatives of one potential, continuous over edges, at a microsecond instead of the dense system that a
// place costs. Facets are made when asked for, by one thread; others may use those that are made. A question allocates
// nothing.

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "solver/sites/site_field.hpp"

namespace forefeel {

class FieldPatches {
 public:
  explicit FieldPatches(std::shared_ptr<const SiteField> field);
  ~FieldPatches();

  // Makes the patch of a facet if it is missing; one thread at a time. Ten places of the field.
  void make(std::int32_t facet);
  bool has(std::int32_t facet) const;
  // Of a place on a facet that has a patch, with slopes. root: also what corrections by states need.
  void fill(const SurfacePlace& place, bool root, SiteModel& model) const;
  const SiteField& field() const { return *field_; }

 private:
  struct Patch;
  std::shared_ptr<const SiteField> field_;
  std::vector<std::atomic<const Patch*>> patches_;  // by facet
  std::vector<std::unique_ptr<const Patch>> made_;
};

}  // namespace forefeel
