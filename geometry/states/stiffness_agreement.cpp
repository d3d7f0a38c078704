#include "geometry/states/stiffness_agreement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_pairs = 500, neighbours = 8, fewest = 3, enough_to_fit = 6;
constexpr double like = 0.7, clearly_alike = 0.9, linear = 0.95;  // correlations

struct NearState {
  double distance2 = std::numeric_limits<double>::infinity();
  const State* state = nullptr;
};

// The nearest usable states at other positions of the same site, by distance.
std::array<NearState, neighbours> nearest(std::span<const State> states, const State& from) {
  std::array<NearState, neighbours> best{};
  for (const State& state : states) {
    if (!state.usable() || !state.force.allFinite()) continue;
    if (from.has_site() && state.site != from.site) continue;
    const double distance2 = (state.at - from.at).squaredNorm();
    if (distance2 == 0 || distance2 >= best.back().distance2) continue;
    auto at = std::ranges::upper_bound(best, distance2, {}, &NearState::distance2);
    std::move_backward(at, best.end() - 1, best.end());
    *at = {distance2, &state};
  }
  return best;
}

struct Fit {
  double scale = 0, correlation = 0;
  bool linear = false;  // the forces change linearly
};

// Correlation of the changes of force with those of the matrix that fits them best.
double fitted_correlation(const Eigen::MatrixXd& moves, const Eigen::MatrixXd& changes) {
  const Eigen::MatrixXd fitted = moves * least_squares(moves, changes);
  return (fitted.array() * changes.array()).sum() / std::max(fitted.norm() * changes.norm(), 1e-300);
}

std::optional<Fit> fit_around(std::span<const State> states, const State& a) {
  double both = 0, expected2 = 0, found2 = 0;
  Eigen::Index count = 0;
  Eigen::MatrixXd moves(neighbours, 3), changes(neighbours, 3);
  for (const NearState& near : nearest(states, a)) {
    if (!near.state) continue;
    const Vec3 move = near.state->at - a.at, expected = -a.stiffness * move;
    const Vec3 found = near.state->force - a.force;
    both += expected.dot(found), expected2 += expected.squaredNorm(), found2 += found.squaredNorm();
    moves.row(count) = move.transpose();
    changes.row(count++) = found.transpose();
  }
  if (count < Eigen::Index(fewest) || !(found2 > 0)) return {};
  Fit fit{.linear = count >= Eigen::Index(enough_to_fit) &&
                    fitted_correlation(moves.topRows(count), changes.topRows(count)) > linear};
  if (expected2 > 0) fit.scale = both / expected2, fit.correlation = both / std::sqrt(expected2 * found2);
  return fit;
}

}  // namespace

StiffnessAgreement stiffness_agreement(std::span<const State> states) {
  std::vector<const State*> with;
  for (const State& state : states)
    if (state.usable() && state.force.allFinite() && state.has_stiffness()) with.push_back(&state);
  StiffnessAgreement found;
  std::vector<double> scales;
  const std::size_t count = std::min(with.size(), most_pairs);
  std::vector<std::optional<Fit>> fits(count);
#pragma omp parallel for schedule(dynamic, 4)
  for (std::size_t k = 0; k < count; ++k) fits[k] = fit_around(states, *with[k * with.size() / count]);
  for (std::size_t k = 0; k < count; ++k) {
    const std::optional<Fit>& fit = fits[k];
    if (!fit) continue;
    ++found.tried;
    if (!(std::abs(fit->correlation) > like)) {
      const State& state = *with[k * with.size() / count];
      const bool zero = state.stiffness.isZero(0);
      found.zero += zero && fit->linear && !state.force.isZero(0) ? 1 : 0;
      found.unlike += !zero && fit->linear ? 1 : 0;
      continue;
    }
    ++found.compared;
    found.opposite += fit->scale < 0;
    found.surely_opposite += fit->scale < 0 && fit->correlation < -clearly_alike;
    scales.push_back(std::abs(fit->scale));
  }
  if (scales.empty()) return found;
  const auto middle = scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2);
  std::nth_element(scales.begin(), middle, scales.end());
  found.scale = *middle;
  return found;
}

std::string disagreement_in_words(const StiffnessAgreement& found) {
  if (found.zero > 0)
    return fmt::format(
        "the stiffness (k11 to k33) is 0 at {} of {} states although the forces beside {} differ; "
        "expected K = -df/dx, or empty cells where it is unknown",
        found.zero, found.tried, found.zero == 1 ? "it" : "them");
  if (2 * found.unlike > found.tried && found.unlike >= fewest)
    return fmt::format(
        "the stiffness (k11 to k33) is not that of the forces of neighbouring states, at {} of {} "
        "states compared; expected K = -df/dx, k12 = -dfx/dy",
        found.unlike, found.tried);
  if (found.compared < fewest || 3 * found.compared < found.tried) return {};
  const double share = static_cast<double>(found.opposite) / static_cast<double>(found.compared);
  if (share > 0.05 || found.surely_opposite > 0)
    return fmt::format(
        "the stiffness (k11 to k33) has the other sign of what the forces of neighbouring states show, at {} "
        "of {} "
        "states compared; expected K = -df/dx, positive for a body that resists",
        found.opposite == found.compared ? std::string("all") : std::to_string(found.opposite),
        found.compared);
  if (found.scale > 1.0 / 5 && found.scale < 5) return {};
  return fmt::format(
      "the stiffness (k11 to k33) is {:.2g} times what the forces of neighbouring states show, at {} states "
      "compared; "
      "expected N/m, as forces in N and positions in m",
      1 / found.scale, found.compared);
}

}  // namespace forefeel
