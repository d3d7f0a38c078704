#pragma once
// The state space: the known equilibria over positions of the tip, indexed by position (Peterlík: configuration space).
// One thread (that of the planner) inserts. While it does not insert, many threads may call const members. Ids are
// numbers from 0 in order of insertion.

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/coverage/coverage.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

class DelaunayIndex;
class PointOctree;
class Regions;
struct PathWalk;

class StateSpace {
 public:
  explicit StateSpace(StateSpaceOptions options);
  ~StateSpace();
  StateSpace(StateSpace&&) noexcept;
  StateSpace& operator=(StateSpace&&) noexcept;

  const StateSpaceOptions& options() const;
  std::size_t size() const;
  bool empty() const { return size() == 0; }
  const State& operator[](StateId id) const;

  struct Insertion {
    StateId id;           // of the new state, or of the known one
    bool is_new = false;  // false: a state lies within merge_distance; the known one is kept
  };
  // InputError, and nothing is inserted, if the state is not usable() or its position or force is not finite. A force
  // of three NaN (unknown) is accepted: such a state counts for coverage only.
  Insertion insert(State state);

  Coverage coverage(const Vec3& q) const;  // label and measures at q
  Label label(const Vec3& q) const;        // the same label, cheaper
  Label label(const Vec3& q,
              PathWalk& walk) const;  // the same, even cheaper along a path (index/path_walk.hpp)
  Label region_label(
      const Vec3& q) const;  // of the voxel that holds q (regions.hpp); outside the box, label(q)
  double spacing_at(const Vec3& q) const;                                       // h(q) [m]
  void nearest(const Vec3& q, std::size_t n, std::vector<StateId>& out) const;  // by distance, ties by id
  void within(const Vec3& q, double radius, std::vector<StateId>& out) const;   // the same order
  StateId find(const Vec3& q) const;  // the state within merge_distance of q, or an invalid id

  const DelaunayIndex& delaunay() const;
  const PointOctree& points() const;
  Regions regions(
      const std::function<void(double)>& progress = {}) const;  // of the box, made anew by each call

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The positions of the lattice {k h}^3 within the box, outward from rest, ties by (z, y, x).
std::vector<Vec3> lattice(const Box& box, double spacing);

// The spacing h [m] of states that come without one. A full cubic lattice of side h has Delaunay cells of
// circumradius R = sqrt(3)/2 h, so
//   h = 2/sqrt(3) times the third quartile of R over the cells next to the states,
// of one cell each, in a random direction. It is h for a full lattice, about h for one that is jittered or has gaps,
// and for random places of density n about 1.2 n^(-1/3): about nine tenths of their hull are safe then. Where most
// states lie on a surface or a stroke as seen by their 24 nearest (the least, or the middle, variance of these is below
// 2 % of the largest), it is the median distance to the fourth, or second, nearest: the side of a square lattice, the
// step of even strokes, and 1.1 times n^(-1/2), or 1/n, at random. `unknown` with fewer than two positions. With more
// than 20 000 states only every k-th is measured, at most 20 000 of them; all states count as neighbours. States at one
// position count once. O(n log n).
double estimate_spacing(std::span<const State> states);
// The same, and whether most states fill a volume (3), lie on a surface (2) or on strokes (1) in this sense.
struct EstimatedSpacing {
  double spacing = unknown;  // [m]
  int dimension = 3;
};
EstimatedSpacing estimated_spacing(std::span<const State> states);

}  // namespace forefeel
