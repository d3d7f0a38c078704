#include "approx/model/jet_set.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "approx/loops/jet_sums.hpp"
#include "approx/model/model.hpp"
#include "approx/model/model_data.hpp"
#include "geometry/common/cube_directions.hpp"
#include "geometry/states/energy_jet.hpp"

namespace forefeel {
namespace {

constexpr double floor_squared = 1e-12;    // e_0^2 [N^2]
constexpr double no_jet = 1e60;            // e_0^2 of padding
constexpr double sticky = 0.8;             // factor of e for members of the last choice
constexpr double beyond_confirmed = 1.25;  // trust over c
constexpr double below_surprise = 0.8;     // trust over s
constexpr double worst = 3;                // errors above this many e are a surprise
constexpr double least_trust = 0.5;        // spacings
constexpr double least_energy_share =
    0.1;  // of the tolerance: what energies of one branch may differ by, over the way
// The radius R of a jet: where e reaches this share of the force, in a quarter of the directions.
constexpr double radius_share = 0.5;
constexpr double back_within = 2.0 / 3;  // of that share: where a jet is taken again
constexpr double most_radius = 50;       // spacings
// A jet of a smaller radius is none: the hand leaves it before the next model comes. It lies beside a fold.
constexpr double least_radius = 0.25;  // spacings
// Farther than this many R from the jets of a model its force is held constant.
constexpr double hold_radii = 1.5;

double factorials(int a, int b, int c) {
  constexpr std::array<double, 6> of{1, 1, 2, 6, 24, 120};
  return of[static_cast<std::size_t>(a)] * of[static_cast<std::size_t>(b)] * of[static_cast<std::size_t>(c)];
}

// Where e = share of the force; `longest` if it is nowhere before.
double radius_along(const State& state, const Vec3& u, double share, double longest) {
  const EnergyJet& jet = *state.jet;
  std::array<double, 3> size;  // of the gradients of degrees 3, 4, 5 at u
  Vec3 before = Vec3::Zero();
  for (int degree = 3; degree <= 5; ++degree) {
    const Vec3 now = jet_terms(jet, u, degree).gradient;
    size[static_cast<std::size_t>(degree - 3)] = (now - before).norm();
    before = now;
  }
  const double slope = (state.stiffness * u).norm(), force = state.force.norm();
  const auto too_far = [&](double r) {
    const double third = r * r * size[0], fourth = third * r * size[1] / std::max(size[0], 1e-300),
                 fifth = r * r * r * r * size[2];
    const double e = jet.order == 2 ? third : jet.order == 3 ? fourth : std::hypot(fifth, 0.5 * fourth);
    return e > share * std::max(force, slope * r);
  };
  if (!too_far(longest)) return longest;
  double low = 0, high = longest;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (too_far(middle) ? high : low) = middle;
  }
  return high;
}

// Solved, so that its force confirms or refutes a jet.
bool is_evidence(const State& state) {
  return state.solve.status == SolveStatus::converged || state.jet;
}

double radius_of(const State& state, double longest) {
  std::array<double, cube_direction_count> all;
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = radius_along(state, cube_directions()[i], radius_share, longest);
  std::ranges::nth_element(all, all.begin() + 6);
  return all[6];
}

}  // namespace

JetSet::JetSet(const StateSpace& space, const ModelOptions& options)
    : space_(space),
      most_(std::min(options.neighbours, most_jets)),
      tolerance_{.value = options.tolerance, .floor = options.floor},
      spacing_(options.length > 0 ? options.length : space.options().spacing) {}

double& JetSet::value(std::size_t jet, std::size_t row) {
  return blocks_[jet / jets::lanes * jets::block_size + row * jets::lanes + jet % jets::lanes];
}

std::size_t JetSet::place_of(StateId id) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(ids_, id) - ids_.begin());
}

JetSet::Trust JetSet::trust(StateId id) const {
  return trusts_[place_of(id)];
}

void JetSet::add(StateId id, const State& state, double radius) {
  const std::size_t jet = ids_.size();
  ids_.push_back(id);
  if (jet % jets::lanes == 0) {
    blocks_.resize(blocks_.size() + jets::block_size, 0.0);
    for (std::size_t lane = 0; lane < jets::lanes; ++lane) {
      value(jet + lane, jets::row_floor) = no_jet;
      value(jet + lane, jets::row_radius) = 1;
    }
    squared_.resize(squared_.size() + jets::lanes);
    energies_.resize(squared_.size());
  }
  const EnergyJet& of = *state.jet;
  constexpr std::array<std::array<Eigen::Index, 2>, 6> pairs{
      {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
  for (std::size_t i = 0; i < 3; ++i) {
    value(jet, jets::row_at + i) = state.at[static_cast<Eigen::Index>(i)];
    value(jet, jets::row_slope + i) = -state.force[static_cast<Eigen::Index>(i)];
    value(jet, jets::row_shares + i) = 0;
  }
  for (std::size_t p = 0; p < 6; ++p)
    value(jet, jets::row_bend + p) =
        0.5 * (state.stiffness(pairs[p][0], pairs[p][1]) + state.stiffness(pairs[p][1], pairs[p][0]));
  value(jet, jets::row_energy) = state.energy;
  std::size_t at = 0;
  for (int degree = 3; degree <= 5; ++degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= 0; --b, ++at)
        value(jet, jets::row_third + at) = of.coefficients[at] * factorials(a, b, degree - a - b);
  if (of.order >= 4) {
    value(jet, jets::row_shares + 1) = 0.25;
    value(jet, jets::row_shares + 2) = 1;
  } else {
    value(jet, jets::row_shares + static_cast<std::size_t>(of.order - 2)) = 1;
  }
  value(jet, jets::row_floor) = floor_squared;
  value(jet, jets::row_radius) = radius;
  limits_.push_back(of.limit);
  trusts_.push_back({.distance = 0, .confirmed = 0, .surprised = std::numeric_limits<double>::infinity()});
}

void JetSet::set_trust(std::size_t jet) {
  Trust& trust = trusts_[jet];
  trust.distance =
      std::min(std::max({limits_[jet], least_trust * spacing_, beyond_confirmed * trust.confirmed}),
               below_surprise * trust.surprised);
  value(jet, jets::row_trust) = 1 / (trust.distance * trust.distance);
  const double over = trust.surprised / trust.distance * (trust.surprised / trust.distance) - 1;
  value(jet, jets::row_growth) = std::max(1.0, trust.excess / (over * over * over));
}

// estimates: of the block of the jet, at the other state.
void JetSet::judge(std::size_t jet, const State& other, const double* estimates) {
  const std::size_t lane = jet % jets::lanes;
  Vec3 at, predicted;
  for (std::size_t i = 0; i < 3; ++i) {
    at[static_cast<Eigen::Index>(i)] = value(jet, jets::row_at + i);
    predicted[static_cast<Eigen::Index>(i)] = estimates[(2 + i) * jets::lanes + lane];
  }
  Trust& trust = trusts_[jet];
  const double distance = (other.at - at).norm(), error = (predicted - other.force).norm();
  const double most = std::max(worst * std::sqrt(estimates[lane]), tolerance_.limit(other.force.norm()));
  if (!(error <= most)) {  // also where it is not finite
    if (distance < trust.surprised) {
      trust.surprised = distance;
      trust.excess = error * error / estimates[lane];
      if (trust.confirmed > distance) confirm_again(jet);
    }
  } else if (distance < trust.surprised && distance > trust.confirmed) {
    trust.confirmed = distance;
  }
}

// c, after s became less: from all states again.
void JetSet::confirm_again(std::size_t jet) {
  trusts_[jet].confirmed = 0;
  std::array<double, jets::estimate_rows * jets::lanes> estimates;
  for (std::uint32_t i = 0; i <= seen_ && i < space_.size(); ++i) {
    const State& other = space_[StateId{i}];
    if (!is_evidence(other) || StateId{i} == ids_[jet]) continue;
    jets::loops().estimates(blocks_.data() + jet / jets::lanes * jets::block_size, other.at.data(),
                            estimates.data());
    judge(jet, other, estimates.data());
  }
}

void JetSet::learn() {
  std::array<double, jets::estimate_rows * jets::lanes> estimates;
  for (; seen_ < space_.size(); ++seen_) {
    const StateId id{static_cast<std::uint32_t>(seen_)};
    const State& state = space_[id];
    if (!is_evidence(state)) continue;
    largest_force_ = std::max(largest_force_, state.force.norm());
    for (std::size_t first = 0; first < ids_.size(); first += jets::lanes) {
      jets::loops().estimates(blocks_.data() + first / jets::lanes * jets::block_size, state.at.data(),
                              estimates.data());
      for (std::size_t jet = first; jet < std::min(ids_.size(), first + jets::lanes); ++jet) {
        judge(jet, state, estimates.data());
        set_trust(jet);
      }
    }
    if (!state.jet || !state.has_stiffness() || !std::isfinite(state.energy)) continue;
    const double radius = radius_of(state, most_radius * spacing_);
    if (radius < least_radius * spacing_) continue;
    add(id, state, radius);
    const std::size_t jet = ids_.size() - 1;
    const double* const block = blocks_.data() + jet / jets::lanes * jets::block_size;
    for (std::uint32_t i = 0; i < seen_; ++i) {
      const State& other = space_[StateId{i}];
      if (!is_evidence(other)) continue;
      jets::loops().estimates(block, other.at.data(), estimates.data());
      judge(jet, other, estimates.data());
    }
    set_trust(jet);
  }
}

void JetSet::choose(const Vec3& x, std::vector<StateId>& out) {
  out.clear();
  std::array<double, jets::estimate_rows * jets::lanes> estimates;
  for (std::size_t first = 0; first < ids_.size(); first += jets::lanes) {
    jets::loops().estimates(blocks_.data() + first / jets::lanes * jets::block_size, x.data(),
                            estimates.data());
    std::copy_n(estimates.begin() + jets::lanes, jets::lanes,
                squared_.begin() + static_cast<std::ptrdiff_t>(first));
    std::copy_n(estimates.begin() + 5 * jets::lanes, jets::lanes,
                energies_.begin() + static_cast<std::ptrdiff_t>(first));
  }
  for (const StateId id : last_) squared_[place_of(id)] *= sticky * sticky;
  out.assign(ids_.begin(), ids_.end());
  if (out.empty()) return;
  const std::size_t count = std::min(most_, out.size());
  std::partial_sort(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(count), out.end(),
                    [&](StateId a, StateId b) {
                      const double qa = squared_[place_of(a)], qb = squared_[place_of(b)];
                      return qa < qb || (qa == qb && a < b);
                    });
  out.resize(count);
  std::erase_if(out, [&, best = out.front()](StateId id) { return on_another_branch(id, best, x); });
  last_.assign(out.begin(), out.end());
}

bool JetSet::lost(const Vec3& x, StateId best) {
  const State& state = space_[best];
  // A stiffness beside a fold may be of any size, the force is not.
  const double slope = (state.stiffness * (x - state.at)).norm();
  const double force = std::max(state.force.norm(), std::min(slope, largest_force_));
  const double share = lost_ ? radius_share * back_within : radius_share;
  lost_ = std::sqrt(squared_[place_of(best)]) > share * std::max(force, tolerance_.floor);
  return lost_;
}

// Whether the energies of two jets differ at x by more than their estimates, over the way from their states, explain.
bool JetSet::on_another_branch(StateId id, StateId best, const Vec3& x) const {
  const std::size_t i = place_of(id), b = place_of(best);
  const double way = (space_[id].at - x).norm(), way_of_best = (space_[best].at - x).norm();
  const double least = least_energy_share * tolerance_.limit(space_[best].force.norm());
  return std::abs(energies_[i] - energies_[b]) > std::max(std::sqrt(squared_[i]), least) * way +
                                                     std::max(std::sqrt(squared_[b]), least) * way_of_best;
}

void JetSet::write(std::span<const StateId> chosen, ModelDraft& draft) const {
  draft.clear();
  ModelData& out = draft.data();
  ModelData::Jets& model = out.jets;
  model.blocks = (chosen.size() + jets::lanes - 1) / jets::lanes;
  model.data.assign(model.blocks * jets::block_size, 0.0);
  double radius = 0, apart = 0, reference = 0;
  for (std::size_t slot = 0; slot < model.blocks * jets::lanes; ++slot) {
    double* const to = model.data.data() + slot / jets::lanes * jets::block_size + slot % jets::lanes;
    if (slot >= chosen.size()) {
      to[jets::row_floor * jets::lanes] = no_jet;
      to[jets::row_radius * jets::lanes] = 1;
      continue;
    }
    const std::size_t jet = place_of(chosen[slot]);
    const double* const from = blocks_.data() + jet / jets::lanes * jets::block_size + jet % jets::lanes;
    for (std::size_t row = 0; row < jets::rows; ++row) to[row * jets::lanes] = from[row * jets::lanes];
    if (slot == 0) {
      reference = to[jets::row_energy * jets::lanes];
      model.centre = space_[chosen[0]].at;
    }
    to[jets::row_energy * jets::lanes] -= reference;
    radius = std::max(radius, to[jets::row_radius * jets::lanes]);
    apart = std::max(apart, (space_[chosen[slot]].at - model.centre).norm());
  }
  model.tolerance = tolerance_;
  model.trusted = radius;
  model.hold = hold_radii * radius + apart;
  out.known = true;
  out.states.assign(chosen.begin(), chosen.end());
  // The largest force: at the states, and around them.
  double largest = 0;
  jets::Blend blend;
  for (const StateId id : chosen) largest = std::max(largest, space_[id].force.norm());
  for (const double distance : {radius, model.hold})
    for (const Vec3& u : cube_directions()) {
      const Vec3 place = model.centre + distance * u;
      jets::loops().blend(model.blocks, model.data.data(), place.data(), blend);
      largest = std::max(largest, Eigen::Map<const Vec3>(blend.gradient).norm());
    }
  out.bound = 1.25 * largest;
}

}  // namespace forefeel
