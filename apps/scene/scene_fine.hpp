#pragma once
// The fine body of a scene: body.fine = { elements = N, element = "quadratic" }. Its rest jet is computed once, and
// that of the scene's own body with it, and kept in the cache folder; their difference is added to what the body
// answers (solver/body/fine_jet.hpp).

#include <cstddef>
#include <functional>
#include <memory>

#include "geometry/common/error.hpp"
#include "solver/body/body.hpp"
#include "solver/body/fine_jet.hpp"

namespace forefeel {

// The fine body, and what its error is measured by (Refinement), made when an error is first asked for.
struct FineBodies {
  Body first;
  std::function<Body(std::size_t elements)> make;  // another; throws InputError where so many cannot be made
  bool subdivided = false;                         // in eight, from a volume mesh
};

// quiet: no progress line. where: of the key, for errors.
std::shared_ptr<const FineJet> fine_jet_of(const Body& body, FineBodies fine, const InputPlace& where,
                                           bool quiet);

// The body with each tetrahedron split into eight, as often as brings their number nearest to `elements` in ratio.
Body refined_to(const Body& body, std::size_t elements);

}  // namespace forefeel
