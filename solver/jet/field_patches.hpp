#pragma once
// The field of sites for a moving hand: on each facet K(s), the mean normal and the coefficients of degrees 3 to 5 of
// E(s, x) in x are polynomials of s through their exact values at places that lie evenly on the facet and its edges, so
//   E(s, x) = 1/2 x^T K(s) x + sum_j c_j(s) m_j(x),   dE/ds = 1/2 x^T K'(s) x + sum_j c_j'(s) m_j(x)
// are exact derivatives of one potential, at a microsecond instead of the dense system that a place costs. Where two
// polynomials meet, each is turned at the edge to the mean of their derivatives across it, so E is continuously
// differentiable over all edges but those that the smooth surface keeps. Of degree 4; 3 where the edges are shorter
// than half the pad's radius, in the mean. All facets are split alike, each edge in `parts`, as often as it takes
// until K errs by less than 0.2 % at random places (root mean square; at most 4 parts, and 60,000 places).

#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "solver/jet/site_field.hpp"

namespace forefeel {

// Immutable; any thread may ask, and a question allocates nothing.
class FieldPatches {
 public:
  // known: values() of the same field; else they are computed, by the field's threads. progress as SiteField's.
  // Stopped early, no facet has a patch.
  explicit FieldPatches(std::shared_ptr<const SiteField> field, std::span<const double> known = {},
                        const std::function<void(double)>& progress = {}, const std::stop_token& stop = {},
                        KeptPieces* kept = nullptr);

  bool has(std::int32_t facet) const { return first_[static_cast<std::size_t>(facet)] >= 0; }
  // Of a place on a facet that has a patch, with slopes. root: also what corrections by states need.
  void fill(const SurfacePlace& place, bool root, SiteModel& model) const;
  const SiteField& field() const { return *field_; }
  // Of K between its places, relative, root mean square over some random ones.
  double error() const { return values_.empty() ? 0 : values_.back(); }
  const std::vector<double>& values() const { return values_; }  // to be kept

 private:
  std::shared_ptr<const SiteField> field_;
  void place_points(int parts);
  bool find_values(int parts, const std::function<void(double)>& progress, const std::stop_token& stop,
                   KeptPieces* kept);
  void find_turns();
  double measured_error() const;

  int degree_ = 4, parts_ = 1;
  std::vector<SurfacePlace> places_;
  std::vector<std::int64_t> first_;   // by facet, into points_; -1: clamped, no patch
  std::vector<std::int32_t> points_;  // numbers of each facet's places
  std::vector<double> values_;        // by place; then error()
  std::vector<std::int32_t> edges_;   // of facets that have a patch, by part and side, into turns_; -1: kept
  std::vector<std::int64_t> first_edge_;  // by facet, into edges_
  std::vector<double> turns_;             // by edge: coefficients of t^k of what is added across it
};

}  // namespace forefeel
