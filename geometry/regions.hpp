#pragma once
// The labelled leaves of the box of a state space: octree leaves, split where the label differs, down to h/4.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geometry/coverage.hpp"
#include "geometry/types.hpp"

namespace forefeel {

class DelaunayIndex;
class PointOctree;
struct StateSpaceOptions;

class Regions {
 public:
  // The indexes must outlive the regions; StateSpace::regions() makes and keeps one.
  Regions(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options);
  ~Regions();

  // Label of the leaf that contains q; outside the box that of q itself.
  Label label_at(const Vec3& q) const;

  // A state was added; `disturbed` as DelaunayIndex reports it.
  void inserted(const Vec3& at, std::span<const std::uint32_t> disturbed);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
