#pragma once
// Coverage from the states around a place, without a triangulation; inserting and erasing states is fast.
// With s = h(q), the spacing at q:
//   safe     pi_rho(q) <= kappa_s s over the states within rho = 1.45 s (local_spread.hpp), and these states
//            are not coplanar. A place that is safe here is also safe for the triangulation. The converse
//            fails only if a corner of the Delaunay cell lies farther away than rho
//   sparse   delta(q) <= kappa_p s, as for the triangulation
//   gap      q's leaf is empty, and within the gap angle of each of 26 directions there is an occupied leaf
//            within the gap radius
//   blank    otherwise
// In a Coverage made here, spread is pi_rho, alpha the circumradius of its tetrahedron if that proves the
// place safe, and gamma is over the 26 directions. compare_indexes() shows where the labels differ from
// coverage.hpp.

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "geometry/index/adaptive_lattice.hpp"
#include "geometry/index/local_spread.hpp"
#include "geometry/index/path_walk.hpp"
#include "geometry/index/point_octree.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

class OctreeIndex {
 public:
  explicit OctreeIndex(double spacing, CoverageOptions options = {});
  // On an adaptive lattice, whose leaves give h(q).
  explicit OctreeIndex(AdaptiveLattice lattice, CoverageOptions options = {});

  void insert(StateId id, const Vec3& at);
  bool erase(StateId id);  // false: not there
  std::size_t size() const { return points_.size(); }

  Coverage coverage(const Vec3& q) const;
  Label label(const Vec3& q) const;
  // The same along a path: the tetrahedron of states that proved the last place safe often proves the next
  // one, too. Only erase() makes a walk out of date; an additional state cannot invalidate the proof.
  Label label(const Vec3& q, PathWalk& walk) const;
  void nearest(const Vec3& q, std::size_t n, std::vector<StateId>& out) const { points_.nearest(q, n, out); }

  const PointOctree& points() const { return points_; }

 private:
  double spacing_at(const Vec3& q) const { return lattice_ ? lattice_->spacing_at(q) : spacing_; }
  struct Near {
    LocalSpread local;
    std::array<StateId, 4> corner;  // of its tetrahedron
    bool any = false;               // a state within kappa_p s
    bool safe = false;
  };
  Near look_near(const Vec3& q, double s) const;
  double least_side(const Vec3& q, double radius, double enough) const;

  double spacing_;
  CoverageOptions options_;
  std::unique_ptr<AdaptiveLattice> lattice_;
  PointOctree points_;
  std::vector<Vec3> at_;                    // by id
  std::uint64_t version_ = next_version();  // for walks; erase() changes it
};

// The labels of both indexes compared by volume:
//   share = (volume that both label alike, and not blank) / (volume that at least one of them does not label blank) [1]
struct Agreement {
  // volume[d][o]: the triangulation says label d, the octree says label o [m^3]
  ByLabel<ByLabel<double>> volume{};
  double share = 1;
  // The cube in the middle of the longest run of differing cubes along x, and its two labels.
  struct Difference {
    Vec3 at;  // [m]
    Label delaunay, octree;
  };
  std::optional<Difference> worst;  // nothing if no label differs
};

// Over the cubes of side h/4 that regions consist of (voxels.hpp), so the volumes are those of the regions.
Agreement compare_indexes(const Regions& regions, const OctreeIndex& octree);

}  // namespace forefeel
