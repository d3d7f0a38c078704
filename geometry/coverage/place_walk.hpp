#pragma once
// What places that lie together share: the cell of the last label, and the states of a ball, which serve the places
// whose nearest states it certainly holds. The answers are those of StateSpace. The caller owns one for each path and
// thread, and asks about one space, to which states may be added meanwhile.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "geometry/index/path_walk.hpp"
#include "geometry/index/point_octree.hpp"

namespace forefeel {

class PlaceWalk {
 public:
  Label label(const StateSpace& space, const Vec3& q) { return space.label(q, walk_); }
  void nearest(const StateSpace& space, const Vec3& q, std::size_t n, std::vector<StateId>& out);

 private:
  bool choose(const Vec3& q, std::size_t n, std::vector<StateId>& out);

  struct Point {
    Vec3 at;
    std::uint32_t id;
  };
  PathWalk walk_;
  Vec3 centre_ = Vec3::Zero(), last_ = Vec3::Zero();  // last_: of the last search
  double radius_ = -1;                                // [m]; below 0: none
  std::size_t size_ = 0;                              // of the space
  std::vector<Point> points_;                         // all in the ball
  std::vector<PointOctree::Neighbour> found_;
};

}  // namespace forefeel
