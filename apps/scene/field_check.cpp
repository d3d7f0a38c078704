#include "apps/scene/field_check.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "geometry/common/quantiles.hpp"
#include "geometry/states/energy_jet.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {
bool holds(const SurfacePart& part, const SurfaceMap& map, const SurfacePlace& place) {
  if (part.ball && !((place.at - part.ball->first).norm() <= part.ball->second)) return false;
  return part.nodes.empty() || std::ranges::all_of(map.facet(place).corners, [&](NodeIndex node) {
           return std::ranges::binary_search(part.nodes, node);
         });
}

SurfacePart surface_part(const std::string& text, const Body& body, const std::string& where) {
  SurfacePart part;
  if (text.empty()) return part;
  if (const auto group = body.mesh.groups.find(text); group != body.mesh.groups.end()) {
    part.nodes = group->second;
    std::ranges::sort(part.nodes);
    return part;
  }
  std::array<double, 4> number{};
  std::size_t begin = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t end = text.find('/', begin);
    const std::string cell = text.substr(begin, end - begin);
    char* stopped = nullptr;
    number[i] = std::strtod(cell.c_str(), &stopped);
    const bool last = i == 3;
    if (cell.empty() || *stopped != '\0' || !std::isfinite(number[i]) || (end == std::string::npos) != last)
      throw InputError(where,
                       fmt::format("is '{}', expected x/y/z/radius [m], or a node group of the body", text));
    begin = end + 1;
  }
  if (!(number[3] > 0))
    throw InputError(where, fmt::format("has the radius {}, expected one above 0 [m]", number[3]));
  part.ball = {Vec3(number[0], number[1], number[2]), number[3]};
  return part;
}

std::vector<SitedPlace> random_places(const RestSites& sites, const SurfacePart& part, double depth,
                                      std::size_t count, const std::string& where) {
  constexpr int most_tries = 20'000;  // for one place: a part of 1e-4 of the surface is still found
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<SitedPlace> places(count);
  for (SitedPlace& place : places) {
    int tries = 0;
    do place.site = sites.map().random(random);
    while (!holds(part, sites.map(), place.site) && ++tries < most_tries);
    if (tries == most_tries)
      throw InputError(where, "holds no part of the surface that can move, expected one");
    const SiteRest rest = sites.at(place.site, false);
    const Vec3 n = rest.normal, e = n.unitOrthogonal(), b = n.cross(e);
    const double deep = depth * (0.08 + 0.92 * share(random)), far = 0.5 * deep * std::sqrt(share(random)),
                 turn = 2 * std::numbers::pi * share(random);
    place.x = -deep * n + far * (std::cos(turn) * e + std::sin(turn) * b);
    place.clamped_share = rest.clamped_share;
  }
  return places;
}

FieldForce field_force(const SiteModel& model, const Vec3& x) {
  return {model.at(x).force, model.estimate(x)};
}

void solve_places(const RestSites& sites, std::span<const SitedPlace> places, double step, int threads,
                  const std::function<void(State, std::size_t)>& done, const std::stop_token& stop) {
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (stop.stop_requested()) continue;
    Body there = sites.body();
    there.fine.reset();
    there.pad->site = places[i].site.at;
    State state = Solver(std::move(there)).reference(places[i].x, step).state;
    state.site = places[i].site.at;
#pragma omp critical
    done(std::move(state), i);
  }
}

FieldErrors field_errors(const SiteField& field, std::span<const State> states, double floor) {
  std::vector<double> errors;
  for (const State& state : states) {
    if (!state.usable() || !state.has_site() || state.at.isZero()) continue;
    const Vec3 force = field.at(field.rest().map().nearest(state.site), false).at(state.at).force;
    errors.push_back((force - state.force).norm() / std::max(state.force.norm(), floor));
  }
  FieldErrors found{.states = errors.size()};
  if (errors.empty()) return found;
  std::ranges::sort(errors);
  found.p50 = quantile(errors, 0.5, QuantileRule::nearest);
  found.p95 = quantile(errors, 0.95, QuantileRule::nearest);
  found.max = errors.back();
  return found;
}

std::vector<State> rest_states(const SiteField& field) {
  std::vector<State> states;
  for (const FieldSite& site : field.sites()) {
    State& state = states.emplace_back();
    state.site = site.place.at;
    state.force.setZero();
    state.energy = 0;
    state.stiffness = site.stiffness;
    state.jet = std::make_shared<const EnergyJet>(field.jet_of(site));
    state.solve.status = SolveStatus::converged;
  }
  return states;
}

}  // namespace forefeel
