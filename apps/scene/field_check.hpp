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
#include "solver/jet/deep_states.hpp"

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
  double clamped_share = 0;                                         // of the pad there
  bool through = false;                                             // deeper than the body is thick there
  bool counts() const { return !(clamped_share > 0) && !through; }  // in errors and for --error
};
// s uniform by area over the part's unclamped surface; depth uniform to `depth`, sideways up to half of it. The same
// seed gives the same places; a larger count only adds some. InputError at `where` if nothing of the part is free.
std::vector<SitedPlace> random_places(const RestSites& sites, const SurfacePart& part, double depth,
                                      std::size_t count, const std::string& where, unsigned seed = 7);

// The place of the surface nearest to a wanted site. InputError at `where` for one on a clamped facet, or farther from
// the surface than the body is long.
SurfacePlace place_at(const RestSites& sites, const Vec3& wanted, const std::string& where);

struct FieldForce {
  Vec3 force = Vec3::Zero();  // [N]
  double estimate = 0;        // of its error, from the jets' last degrees [N]
};
// With the states' corrections; model: of the field at this place.
FieldForce field_force(const DeepStates& states, const SiteModel& model, const SurfacePlace& place,
                       const Vec3& x);

// A tight solve with a jet of order 4, converged or not, with its site. step [m]: of the way from rest.
State solve_place(const RestSites& sites, const SitedPlace& place, double step);
// Several. done(state, place number) is called by one
// thread at a time.
void solve_places(const RestSites& sites, std::span<const SitedPlace> places, double step, int threads,
                  const std::function<void(State, std::size_t)>& done, const std::stop_token& stop);

// Jets at rest of single places as states at x = 0; fewer if stopped.
std::vector<State> jets_at(const RestSites& sites, std::span<const SurfacePlace> places, int threads,
                           const std::stop_token& stop);

// Relative errors of the field at solved states, |f - f_solved| / max(|f_solved|, floor); NaN without states.
struct FieldErrors {
  double p50 = unknown, p95 = unknown, max = unknown;
  std::size_t states = 0;
  std::vector<double> sorted = {};
  // p95 of all such places is within `error`, with 95 % confidence.
  bool surely_within(double error) const;
};
FieldErrors field_errors(const SiteField& field, std::span<const State> states, double floor);
FieldErrors field_errors(const DeepStates& known, std::span<const State> states, double floor);

// The field with states of a file; a state whose site has no jet at rest there gets one.
std::shared_ptr<const DeepStates> field_with(std::shared_ptr<const SiteField> field,
                                             std::span<const State> states, int threads);

// The error between the sites, |f - f of a jet made at the state's site|, over that of the field; the median of the
// states where the field errs by more than `error`. Above 1/2 denser sites help, below it solved states. NaN: none.
double share_between(const SiteField& field, std::span<const State> states, double error, double floor);

// Of these places the `count` where most is wrong by the estimate, over max(|f|, floor), without those that a chosen
// one serves too; of: by the estimate with states, or by what the field's neighbours differ by.
enum class WorstBy : char { estimate, neighbours };
std::vector<SitedPlace> worst_places(const DeepStates& known, std::span<const SitedPlace> places,
                                     std::size_t count, double floor, WorstBy by, int threads);

// The jets at rest of the field's sites as states at x = 0.
std::vector<State> rest_states(const SiteField& field);

}  // namespace forefeel
