#pragma once
// The Delaunay triangulation of the known states, built one state at a time (CGAL, exact predicates).
//   spread   pi(q) = sqrt(sum lambda_i |v_i - q|^2) over the vertices v_i of the cell that contains q, lambda
//            the barycentric weights [m]; infinite outside the hull and while there is no cell
//   alpha    least circumradius over the cells that contain q [m]
//
// Why pi never grows when a state is added: lift x to (x, |x|^2). The Delaunay triangulation is the lower
// hull of the lifted states, so
//   sum lambda_i |v_i|^2 = min { sum mu_j |x_j|^2 : mu >= 0, sum mu_j = 1, sum mu_j x_j = q },
//   pi^2 = sum lambda_i |v_i|^2 - |q|^2.
// A further state enlarges the feasible set (its mu may stay 0), so the minimum can only fall. The minimum
// does not depend on which of several cospherical triangulations was chosen, so neither does pi. (The
// circumradius alone is not monotone.)
//
// Rounding: a cell counts as flat (coplanar) if its height is below 1e-12 of its edges, or below 64 units in the
// last place of the states' coordinates. At a face of the hull the next cell that is not flat is used instead, so
// q may lie outside the hull by such a height. (A rotated lattice has flat cells at all its faces.)

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "geometry/index/path_walk.hpp"

namespace forefeel {

struct Spread {
  double spread = std::numeric_limits<double>::infinity();  // [m]
  double alpha = std::numeric_limits<double>::infinity();   // [m]; only if requested
  bool inside = false;                                      // in the hull, in a cell that is not flat
  std::array<StateId, 4> states;                            // of one cell that contains q
  std::array<double, 4> weights{};                          // barycentric, >= 0, sum 1
  std::array<Vec3, 4> at;
};

class DelaunayIndex {
 public:
  DelaunayIndex();
  ~DelaunayIndex();
  DelaunayIndex(DelaunayIndex&&) noexcept;
  DelaunayIndex& operator=(DelaunayIndex&&) noexcept;

  int dimension() const;  // of the affine hull of the states; -1 while there are none

  // Adds a state. near: a known state close to it, or an invalid id. Returns the id of the state at exactly
  // this position: the new one, or the one already there. Ids may come in any order and must be below 2^31.
  StateId insert(StateId id, const Vec3& at, StateId near = {});

  Vec3 position(StateId id) const;  // [m]; of a state that is there

  // Const members may run in many threads at once, but not beside insert().
  Spread spread(const Vec3& q, StateId near, bool with_alpha = false) const;
  // The same along a path: starts at the last place of the walk and moves the walk to q.
  Spread spread(const Vec3& q, PathWalk& walk) const;

  // The ball through the corners of a cell holds no state; it is infinite where the cell is flat.
  struct Cell {
    std::array<StateId, 4> states;  // positively oriented
    Vec3 centre;                    // of the ball [m]
    double circumradius = 0;        // [m]
  };
  std::vector<Cell> cells() const;           // finite ones
  std::vector<StateId> hull_states() const;  // corners of the hull's facets

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
