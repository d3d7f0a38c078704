#pragma once
// All known states, indexed by position. One owner (the planner's thread) inserts and queries; other threads get
// immutable values. Ids are dense and in order of insertion.

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/coverage/coverage.hpp"
#include "geometry/index/path_walk.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

class AdaptiveLattice;
class DelaunayIndex;
class Regions;

struct StateSpaceOptions {
  double spacing = 0.006;  // h [m]
  Box box{};               // where states are placed; the HIP may leave it
  CoverageOptions coverage{};
  double merge_distance = 1e-9;  // in spacings: nearer states are one
  // Where given, labels use its h(q) instead of `spacing`, which then sets only the finest regions, spacing / 4, and
  // what counts as one state. Shared and never changed.
  std::shared_ptr<const AdaptiveLattice> lattice = nullptr;
};

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
    StateId id;           // of the new state, or of the one already there
    bool is_new = false;  // false: a state lies within merge_distance; the known one is kept
  };
  Insertion insert(State state);  // state.usable()

  Coverage coverage(const Vec3& q) const;            // label and its measures at q
  Label label(const Vec3& q) const;                  // the same label, cheaper
  Label label(const Vec3& q, PathWalk& walk) const;  // the same, cheapest along a path
  Label region_label(const Vec3& q) const;           // regions().label_at(q) without any regions
  double spacing_at(const Vec3& q) const;            // h(q) [m]
  void nearest(const Vec3& q, std::size_t n, std::vector<StateId>& out) const;  // by distance, ties by id
  void within(const Vec3& q, double radius, std::vector<StateId>& out) const;   // the same order
  StateId find(const Vec3& q) const;  // the state within merge_distance of q, or an invalid id

  const DelaunayIndex& delaunay() const;
  // The labelled leaves of the box; built at the first call, kept up to date by insert() from then on.
  const Regions& regions() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The lattice {k h}^3 within the box, rest included where the box contains it; outward from rest, ties by (z, y, x).
std::vector<Vec3> lattice(const Box& box, double spacing);

}  // namespace forefeel
