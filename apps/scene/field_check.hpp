#pragma once
// How well the field of a scene with contact.anywhere answers: its own estimate, and its error at random places that
// are solved. The body that is answered for is the field's, the fine body if the scene has one.

#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "apps/scene/scene.hpp"
#include "geometry/states/state.hpp"
#include "solver/jet/site_field.hpp"

namespace forefeel {

// A part of the surface: a ball, or the facets of a node group. Neither: all of it.
struct SurfacePart {
  std::optional<std::pair<Vec3, double>> ball;  // centre and radius [m]
  std::vector<NodeIndex> nodes;                 // ascending, of the field's body
};
// "x/y/z/radius", or the name of a node group of the body; empty: all. InputError at `where`.
SurfacePart surface_part(const std::string& text, const Body& body, const std::string& where);
bool holds(const SurfacePart& part, const SurfaceMap& map, const SurfacePlace& place);

// A displacement at a site; both in the axes of the mesh [m].
struct SitedPlace {
  SurfacePlace site;
  Vec3 x = Vec3::Zero();
  double clamped_share = 0;  // of the pad there
};
// s uniform by area over the part's unclamped surface; depth uniform to `depth`, sideways up to half of it. The same
// seed gives the same places; a larger count only adds some. InputError at `where` if nothing of the part is free.
std::vector<SitedPlace> random_places(const RestSites& sites, const SurfacePart& part, double depth,
                                      std::size_t count, const std::string& where);

struct FieldForce {
  Vec3 force = Vec3::Zero();  // [N]
  double estimate = 0;        // of its error, from the jets' last degrees [N]
};
FieldForce field_force(const SiteModel& model, const Vec3& x);

// Tight solves; converged or not, with their sites. done(state, place number) is called by one thread at a time.
void solve_places(const RestSites& sites, std::span<const SitedPlace> places, double step, int threads,
                  const std::function<void(State, std::size_t)>& done, const std::stop_token& stop);

// Relative errors of the field at solved states, |f - f_solved| / max(|f_solved|, floor); NaN without states.
struct FieldErrors {
  double p50 = unknown, p95 = unknown, max = unknown;
  std::size_t states = 0;
};
FieldErrors field_errors(const SiteField& field, std::span<const State> states, double floor);

// The jets at rest of the field's sites as states at x = 0.
std::vector<State> rest_states(const SiteField& field);

}  // namespace forefeel
