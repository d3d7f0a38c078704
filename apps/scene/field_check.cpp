#include "apps/scene/field_check.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

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

namespace {

State rest_state(const Vec3& site, const Mat3& stiffness, const EnergyJet& jet) {
  State state;
  state.site = site;
  state.force.setZero();
  state.energy = 0;
  state.stiffness = stiffness;
  state.jet = std::make_shared<const EnergyJet>(jet);
  state.solve.status = SolveStatus::converged;
  return state;
}

}  // namespace

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
                                      std::size_t count, const std::string& where, unsigned seed) {
  constexpr int most_tries = 20'000;  // for one place: a part of 1e-4 of the surface is still found
  std::mt19937_64 random(seed);
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
    place.through = deep > sites.map().thickness(place.site, n);
  }
  return places;
}

SurfacePlace place_at(const RestSites& sites, const Vec3& wanted, const std::string& where) {
  const SurfacePlace place = sites.map().nearest(wanted);
  const auto refuse = [&](const char* why) {
    return InputError(
        where, fmt::format("the site ({:.6g}, {:.6g}, {:.6g}) is {}", wanted[0], wanted[1], wanted[2], why));
  };
  if (!((place.at - wanted).norm() <= longest_side(sites.body().mesh)))
    throw refuse("farther from the surface than the body is long, expected a place near it, in metres");
  if (sites.map().facet(place).clamped) throw refuse("on a clamped facet, expected a place that can move");
  return place;
}

FieldForce field_force(const DeepStates& states, const SiteModel& model, const SurfacePlace& place,
                       const Vec3& x) {
  return {states.at(model, place, x).force, states.estimated_error(model, place, x)};
}

State solve_place(const RestSites& sites, const SitedPlace& place, double step) {
  Body there = sites.body();
  there.fine.reset();
  there.pad->site = place.site.at;
  State state = Solver(std::move(there)).reference(place.x, step, {.jet = most_jet_order}).state;
  state.site = place.site.at;
  return state;
}

void solve_places(const RestSites& sites, std::span<const SitedPlace> places, double step, int threads,
                  const std::function<void(State, std::size_t)>& done, const std::stop_token& stop) {
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (stop.stop_requested()) continue;
    State state = solve_place(sites, places[i], step);
#pragma omp critical
    done(std::move(state), i);
  }
}

std::vector<State> jets_at(const RestSites& sites, std::span<const SurfacePlace> places, int threads,
                           const std::stop_token& stop) {
  std::vector<State> states(places.size());
  if (places.empty()) return states;
#pragma omp parallel num_threads(std::min(threads, static_cast <int>(places.size())))
  {
    SiteJets jets(sites);
#pragma omp for schedule(dynamic)
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (stop.stop_requested()) continue;
      const RestJet jet = jets.at(places[i]);
      states[i] = rest_state(places[i].at, jet.stiffness, jet.jet);
    }
  }
  std::erase_if(states, [](const State& state) { return !state.has_site(); });
  return states;
}

FieldErrors field_errors(const SiteField& field, std::span<const State> states, double floor) {
  return field_errors(DeepStates({std::shared_ptr<const SiteField>(), &field}), states, floor);
}

FieldErrors field_errors(const DeepStates& known, std::span<const State> states, double floor) {
  std::vector<double> errors;
  for (const State& state : states) {
    if (!state.usable() || !state.has_site() || state.at.isZero()) continue;
    const SurfacePlace place = known.field().rest().map().nearest(state.site);
    const Vec3 force = known.at(known.field().at(place, false), place, state.at).force;
    errors.push_back((force - state.force).norm() / std::max(state.force.norm(), floor));
  }
  FieldErrors found{.states = errors.size()};
  if (errors.empty()) return found;
  std::ranges::sort(errors);
  found.p50 = quantile(errors, 0.5, QuantileRule::nearest);
  found.p95 = quantile(errors, 0.95, QuantileRule::nearest);
  found.max = errors.back();
  found.sorted = std::move(errors);
  return found;
}

bool FieldErrors::surely_within(double error) const {
  const double count = static_cast<double>(states);
  const auto above = static_cast<double>(sorted.end() - std::ranges::upper_bound(sorted, error));
  return states > 0 && above <= 0.05 * count - 1.64 * std::sqrt(0.05 * 0.95 * count);
}

std::shared_ptr<const DeepStates> field_with(std::shared_ptr<const SiteField> field,
                                             std::span<const State> states, int threads) {
  using Site = std::array<double, 3>;
  std::set<Site> made;
  for (const State& state : states)
    if (state.at.isZero()) made.insert({state.site[0], state.site[1], state.site[2]});
  std::vector<SurfacePlace> missing;
  for (const State& state : states)
    if (state.has_site() && state.usable() &&
        made.insert({state.site[0], state.site[1], state.site[2]}).second)
      missing.push_back(field->rest().map().nearest(state.site));
  const std::vector<State> jets = jets_at(field->rest(), missing, threads, {});
  return DeepStates(std::move(field)).with(jets)->with(states);
}

double share_between(const SiteField& field, std::span<const State> states, double error, double floor) {
  std::vector<double> shares;
  std::optional<SiteJets> jets;
  for (const State& state : states) {
    if (!state.usable() || !state.has_site() || state.at.isZero()) continue;
    const SurfacePlace place = field.rest().map().nearest(state.site);
    const Vec3 force = field.at(place, false).at(state.at).force;
    const double wrong = (force - state.force).norm();
    if (wrong <= error * std::max(state.force.norm(), floor)) continue;
    if (!jets) jets.emplace(field.rest());
    const RestJet jet = jets->at(place);
    const Vec3 own = -(jet.stiffness * state.at + jet_terms(jet.jet, state.at).gradient);
    shares.push_back((force - own).norm() / wrong);
  }
  return shares.empty() ? unknown : median(std::move(shares));
}

std::vector<SitedPlace> worst_places(const DeepStates& known, std::span<const SitedPlace> places,
                                     std::size_t count, double floor, WorstBy by, int threads) {
  std::vector<std::pair<double, std::size_t>> worst(places.size());
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (std::size_t i = 0; i < places.size(); ++i) {
    const SiteModel model = known.field().at(places[i].site, false);
    const double wrong = by == WorstBy::estimate ? known.estimated_error(model, places[i].site, places[i].x)
                                                 : model.spread(places[i].x);
    worst[i] = {-wrong / std::max(model.at(places[i].x).force.norm(), floor), i};
  }
  std::ranges::sort(worst);
  const double near = 0.5 * known.field().options().spacing;
  std::vector<SitedPlace> chosen;
  for (const auto& [wrong, i] : worst) {
    if (chosen.size() == count) break;
    const auto serves = [&, place = places[i]](const SitedPlace& other) {
      const double apart = by == WorstBy::estimate ? (place.x - other.x).norm() / (0.4 * other.x.norm()) : 0;
      return (place.site.at - other.site.at).norm() / near + apart < 1;
    };
    if (std::ranges::none_of(chosen, serves)) chosen.push_back(places[i]);
  }
  return chosen;
}

std::vector<State> rest_states(const SiteField& field) {
  std::vector<State> states;
  for (const FieldSite& site : field.sites())
    states.push_back(rest_state(site.place.at, site.stiffness, field.jet_of(site)));
  return states;
}

}  // namespace forefeel
