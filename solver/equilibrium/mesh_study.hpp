#pragma once
// Finds a mesh that is fine enough: compares the force |K x| at one position x [m] over the number of elements. K is
// the stiffness at rest, so each body takes one factorisation.
//   f = f0 + a_k h^p_k,   h = n^(-1/3)
// f: |K x| [N]; n: tetrahedra; k: linear or quadratic elements, each with constant a_k [N] and rate p_k of its
// own; f0: the limit of infinite refinement (Richardson's extrapolation, 1911). Only meshes refined from one another
// count for f0, since only they have the same contact. With three such meshes of a kind, its rate is fitted. With two,
// the rate is fixed at 1.2 (linear) or 1.5 (quadratic): the stress is infinite at the edges of contact and clamp, which
// keeps both rates far below 2 and 4. A single mesh of a kind is not used. The fit is by least squares with weights
// 1 / (h d_k), d_k: difference between the two finest meshes of the kind. So meshes near the limit count most.

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
// uncertainty: the largest change of f0 when one mesh or one kind of elements is left out, or a rate is a quarter
// larger or smaller. Unknown with fewer than two meshes of each kind. Rows without a force, and remeshed ones, are
// ignored.
MeshLimit extrapolated(std::span<const MeshStudyRow> rows);
// Fills the rows' errors.
void compare(std::vector<MeshStudyRow>& rows, const MeshLimit& limit);

// The row of least work among those with an error of at most `error`. A row does not count if a finer one of its kind
// exceeds `error`: a coarse mesh with a small contact can hit the force by chance.
std::optional<std::size_t> cheapest(std::span<const MeshStudyRow> rows, double error);

}  // namespace forefeel
