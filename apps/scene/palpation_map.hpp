#pragma once
// The stiffness at rest over the surface of a body, along the normal under the pad: n . K(s) n, and that of the body
// without the pad in series, n . (K^-1 - I / t)^-1 n. A lump shows in it before anything is pressed.

#include <optional>
#include <vector>

#include "apps/console/document_keys.hpp"
#include "apps/scene/scene_field.hpp"
#include "solver/jet/deep_states.hpp"
#include "solver/jet/rest_sites.hpp"

namespace forefeel {

// At one node of a body's surface.
struct SurfaceStiffness {
  NodeIndex node = 0;
  double area = 0;      // of the free surface, a third of each facet of the node [m^2]
  double with_pad = 0;  // [N/m]
  double alone = 0;     // of the body alone under the pad [N/m]
};

// At the free nodes of the surface of `body`, at the places of the surface of `rest` that are nearest: it may be that
// of a fine body. threads 0: all cores. Ascending by node. Places where the mean normal vanishes are left out.
std::vector<SurfaceStiffness> palpation_map(const RestSites& rest, const Body& body, int threads = 0);

// At one node, where the tip is pressed straight in, x = -depth n: three times the estimated error, over
// max(|f|, floor).
struct SurfaceError {
  NodeIndex node = 0;
  double area = 0;   // [m^2]
  double error = 0;  // [1]
};
std::vector<SurfaceError> error_map(const DeepStates& known, const Body& body, double depth, double floor,
                                    int threads = 0);

// Over the area.
struct StiffnessRange {
  double least = 0, median = 0, greatest = 0;  // [N/m]
};
// nullopt: of an empty map.
std::optional<StiffnessRange> range_over(const std::vector<SurfaceStiffness>& map,
                                         double SurfaceStiffness::*which);

// What `info SCENE` and summaries say of the field of a scene with contact.anywhere.
struct FieldNote {
  std::size_t sites = 0;
  double spacing = 0;                             // of the sites [m]
  double seconds = 0;                             // that making or reading it took
  bool kept = false;                              // read from the cache
  double area = 0;                                // of the free surface [m^2]
  double lift = 0;                                // of the smooth surface from the facets, at most [m]
  std::size_t kept_edges = 0;                     // of the mesh, sharper than feature_angle
  std::size_t faceted_nodes = 0;                  // around which the surface stays that of the facets
  std::optional<StiffnessRange> with_pad, alone;  // nullopt: no free node on the surface
  std::optional<double> friction = {};            // nullopt: bonded
};
// Solves the map of stiffness.
FieldNote field_note(const Scene& scene, const FieldFound& found, const Globals& globals);
const JsonKeys<FieldNote>& field_keys();
std::vector<std::string> in_words(const FieldNote& note);  // lines

}  // namespace forefeel
