#pragma once
// Which mesh is fine enough? The force |K x| at one position x [m] against the number of elements, K the
// stiffness at rest: one factorisation of each body.
//   f = f0 + a_k h^p_k,   h = n^(-1/3)
// f: |K x| [N]; n: tetrahedra; k: linear or quadratic elements, each with constant a_k [N] and rate p_k of its
// own; f0: the force of a mesh without end (Richardson's extrapolation, 1911). Only meshes that are refined
// from one another count for f0, since only they have the same contact. A kind of elements with fewer than
// three of these has the rate 1.2 or 1.5: edges of contact and clamp, where the stress is infinite, hold both
// kinds far below 2 and 4. One with a single mesh says nothing. With three the rate is fitted. Least squares
// with weights 1 / (h d_k), d_k: by how much the two finest meshes of the kind differ. What is near its limit
// counts most.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

struct MeshStudyRow {
  std::size_t elements = 0;  // n
  Element element = Element::linear;
  std::int64_t nodes = 0;    // of the elements, mid-edge nodes included
  double force = unknown;    // f [N]; unknown where rest is no stable equilibrium
  double work = unknown;     // multiplications of a factorisation
  double seconds = unknown;  // of the factorisation and its solves
  bool remeshed = false;     // a mesh of its own, not refined from the others
  double error = unknown;    // |f - f0| / f0, once f0 is known
};

MeshStudyRow study_row(const std::shared_ptr<const Body>& body, const Vec3& x);

struct MeshLimit {
  double force = unknown;               // f0 [N]
  double beyond = unknown;              // |f0 - f| / f0 of the row nearest to f0
  double uncertainty = unknown;         // of f0, relative: see below
  double rate[2] = {unknown, unknown};  // p of linear and quadratic elements; unknown: not fitted
  bool known() const { return force == force; }
};
// uncertainty: by how much f0 changes at most where one mesh is left out, one kind of elements is left out, or a rate is
// a quarter larger or smaller. Not known with fewer than two meshes of each kind. Rows without a force, and remeshed ones, are left out.
MeshLimit extrapolated(std::span<const MeshStudyRow> rows);
// Fills the rows' errors.
void compare(std::vector<MeshStudyRow>& rows, const MeshLimit& limit);

// Of the rows with an error of at most `error`, that of the least work. A row does not count if a finer one of its kind
// has a larger error than that: a coarse mesh with a small contact can hit the force by chance.
std::optional<std::size_t> cheapest(std::span<const MeshStudyRow> rows, double error);

}  // namespace forefeel
