#pragma once
// Coverage by counting states in leaves, without a triangulation: cheap to insert into and to erase from.
// With s = h(q) the spacing at q, and the corners of q's leaf in the lattice {k s}^3:
//   safe     at least 7 of the 8 corners are known (a state within s/2 of the corner along every axis), or at least
//            3 are and q lies inside the hull of the states within 1.45 s
//   sparse   delta(q) <= kappa_p s, as for the triangulation
//   gap      q's leaf is empty and along each of 26 directions some occupied leaf within the gap radius lies no
//            farther than the gap angle away
//   blank    otherwise
// spread and alpha of a safe place are the bounds that its corners give; gamma is that over the 26 directions.
// These labels approximate those of coverage.hpp; compare_indexes() in agreement.hpp says where they differ.

#include <memory>
#include <span>
#include <vector>

#include "geometry/adaptive_lattice.hpp"
#include "geometry/coverage.hpp"
#include "geometry/point_octree.hpp"
#include "geometry/state.hpp"

namespace forefeel {

class OctreeIndex {
 public:
  explicit OctreeIndex(double spacing, CoverageOptions options = {});
  // On an adaptive lattice: h(q) from its leaves.
  explicit OctreeIndex(AdaptiveLattice lattice, CoverageOptions options = {});

  void insert(StateId id, const Vec3& at);
  bool erase(StateId id);                      // false: not there
  std::size_t size() const { return points_.size(); }

  Coverage coverage(const Vec3& q) const;
  Label label(const Vec3& q) const;
  void nearest(const Vec3& q, std::size_t n, std::vector<StateId>& out) const;
  void within(const Vec3& q, double radius, std::vector<StateId>& out) const;

  const Vec3& position(StateId id) const { return at_[id.value]; }
  const AdaptiveLattice* lattice() const { return lattice_.get(); }
  AdaptiveLattice* lattice() { return lattice_.get(); }
  // Where to add states: points of the adaptive lattice with no state within half their spacing, outward from rest.
  std::vector<AdaptiveLattice::Point> proposals() const;

 private:
  double spacing_at(const Vec3& q) const { return lattice_ ? lattice_->spacing_at(q) : spacing_; }
  bool safe(const Vec3& q, double s, double& reach) const;
  double least_side(const Vec3& q, double radius) const;

  double spacing_;
  CoverageOptions options_;
  std::unique_ptr<AdaptiveLattice> lattice_;
  PointOctree points_;
  std::vector<Vec3> at_;                       // by id
};

}  // namespace forefeel
