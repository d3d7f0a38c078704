#pragma once
// The fine body of a scene: body.fine = { elements = N, element = "quadratic" }. Its rest jet is computed once, and
// that of the scene's own body with it, and kept in the cache folder; their difference is added to what the body
// answers (solver/body/fine_jet.hpp).

#include <cstddef>
#include <memory>
#include <optional>

#include "geometry/common/error.hpp"
#include "solver/body/body.hpp"
#include "solver/body/fine_jet.hpp"

namespace forefeel {

// The fine body, and one of larger elements, which shows what refinement still changes; none where the first one's
// elements are too few for that.
struct FineBodies {
  Body first;
  std::optional<Body> second;
};

// quiet: no progress line. where: of the key, for errors.
std::shared_ptr<const FineJet> fine_jet_of(const Body& body, const FineBodies& fine, const InputPlace& where,
                                           bool quiet);

// The body with each tetrahedron split into eight, as often as brings their number nearest to `elements` in ratio.
Body refined_to(const Body& body, std::size_t elements);

}  // namespace forefeel
