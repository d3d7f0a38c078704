#pragma once
// The state space: the known equilibria over positions of the tip, indexed by position (Peterlík: configuration space).
// One thread (that of the planner) inserts. While it does not insert, many threads may call const members except
// regions(). Ids are numbers from 0 in order of insertion.

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/coverage/state_space_options.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

class DelaunayIndex;
class Regions;
struct PathWalk;

// InputError for a spacing that is not a positive length, and for a sparse distance below the safe spread.
void check_options(const StateSpaceOptions& options);

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
              PathWalk& walk) const;        // the same, even cheaper along a path (index/path_walk.hpp)
  Label region_label(const Vec3& q) const;  // what regions().label_at(q) returns, without making regions
  double spacing_at(const Vec3& q) const;   // h(q) [m]
  void nearest(const Vec3& q, std::size_t n, std::vector<StateId>& out) const;  // by distance, ties by id
  void within(const Vec3& q, double radius, std::vector<StateId>& out) const;   // the same order
  StateId find(const Vec3& q) const;  // the state within merge_distance of q, or an invalid id

  const DelaunayIndex& delaunay() const;
  // The labelled leaves of the box. Made by the first call; from then on insert() keeps them up to date.
  const Regions& regions() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The positions of the lattice {k h}^3 within the box, outward from rest, ties by (z, y, x).
std::vector<Vec3> lattice(const Box& box, double spacing);

}  // namespace forefeel
