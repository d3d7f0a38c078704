#pragma once
// The largest empty cone. For unit directions u_i from an apex q,
//   gamma = max_a min_i angle(a, u_i),   cos gamma = min_a max_i a . u_i   over unit axes a
// is the half-angle of the largest cone that contains no direction. If the apex lies inside the hull of the
// directions, cos gamma is the least distance of a facet of that hull; otherwise cos gamma = -|p|, p the
// point of the hull nearest to the apex. So gamma < 90 degrees exactly if q lies strictly inside the hull of
// the states.
//
// The full hull is not built. A small hull grows: the direction farthest beyond its lowest facet is added, until
// no direction lies beyond that facet. The small hull lies within the full hull, so its facets alone can prove
// gamma <= threshold.

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

// Directions as three arrays. Reused between queries: clear() keeps the memory.
class Directions {
 public:
  void clear() { x_.clear(), y_.clear(), z_.clear(); }
  std::size_t size() const { return x_.size(); }
  void push(const Vec3& unit) { x_.push_back(unit.x()), y_.push_back(unit.y()), z_.push_back(unit.z()); }
  Vec3 operator[](std::size_t i) const { return {x_[i], y_[i], z_[i]}; }
  // The index with the largest axis . u_i, and that value.
  std::size_t farthest(const Vec3& axis, double& value) const;

 private:
  std::vector<double> x_, y_, z_;
};

struct EmptyCone {
  double cos_half = -1;       // cos gamma; -1 without directions
  Vec3 axis = Vec3::UnitX();  // unit; of one of the largest empty cones
};

struct ConeFacet {
  std::array<std::uint32_t, 3> corner;
  Vec3 normal;    // unit, outward
  double offset;  // normal . u on the facet
};

class ConeSolver {
 public:
  // gamma and its axis.
  EmptyCone largest_empty(const Directions& directions);

  // True if no empty cone is wider than arccos(cos_threshold): cos gamma >= cos_threshold, within 1e-9. False
  // for directions that lie in one plane. If false, *witness (if given) is the axis of a wider empty cone, or
  // NaN if only the common plane decided.
  bool at_most(const Directions& directions, double cos_threshold, Vec3* witness = nullptr);

 private:
  enum class Stop { bounded, open, flat };
  Stop grow(const Directions& directions, double cos_threshold, std::size_t& lowest);
  EmptyCone finish(const Directions& directions, Stop stop, std::size_t lowest) const;
  bool start(const Directions& directions);
  void add(const Directions& directions, std::uint32_t corner);
  void push_facet(const Directions& directions, std::uint32_t a, std::uint32_t b, std::uint32_t c);
  Vec3 nearest_of_hull(const Directions& directions) const;

  std::vector<ConeFacet> facets_, kept_;
  std::vector<std::array<std::uint32_t, 2>> rim_;
  Vec3 inside_ = Vec3::Zero();
  Vec3 plane_ = Vec3::UnitZ();  // normal of the plane where start() finds the directions flat
};

}  // namespace forefeel
