#include "approx/error/division.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/common/dense.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

constexpr double same_direction = 0.3;  // mismatch of directions that counts as none
constexpr double most_mismatch = 2.5;   // ratio of distances and directions, up to which groups fit
constexpr double most_farther = 4;      // of natural groups, in distances of the places
constexpr std::size_t parts = 8;
constexpr std::size_t enough = 2000;  // positions that tell their distances

Division divide(std::span<const Vec3> at, PositionGroups groups) {
  Division division{.groups = std::move(groups), .part = {}};
  if (division.groups.count < 3) return division;
  division.count = std::min(parts, division.groups.count);
  division.part = spread_over_parts(at, division.groups, division.count);
  return division;
}

// From the nearest position of another part to each position, or to some of very many [m].
std::vector<Vec3> displacements(std::span<const Vec3> at, const Division& division) {
  std::vector<Vec3> from;
  for (std::size_t i = 0; i < at.size(); i += at.size() / enough + 1) {
    double least = std::numeric_limits<double>::infinity();
    from.emplace_back(Vec3::Zero());
    for (std::size_t j = 0; j < at.size(); ++j) {
      if (division.part[division.groups.of[i]] == division.part[division.groups.of[j]]) continue;
      if (const double d = (at[i] - at[j]).squaredNorm(); d < least) least = d, from.back() = at[i] - at[j];
    }
  }
  return from;
}

Mat3 second_moment(std::span<const Vec3> displacements) {
  Mat3 moment = Mat3::Zero();
  for (const Vec3& d : displacements) moment += d * d.transpose() / static_cast<double>(displacements.size());
  return moment;
}

double median_length(std::span<const Vec3> displacements) {
  std::vector<double> all;
  for (const Vec3& d : displacements) all.push_back(d.norm());
  return median(all);
}

// log(d / D): positive where the held-out positions are nearer to the rest.
double nearer(std::span<const Vec3> held, std::span<const Vec3> wanted) {
  const double found = median_length(held), target = median_length(wanted);
  return found > 0 && target > 0 ? std::log(target / found) : std::numeric_limits<double>::infinity();
}

double turned(std::span<const Vec3> held, std::span<const Vec3> wanted) {
  const Modes3 axes = axes_of(second_moment(wanted));
  const Mat3 moment = second_moment(held);
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 u = axes.vectors.col(k);
    const double share = std::max(0.0, axes.values[k]) / axes.values.sum();
    sum += 0.5 * share * std::abs(std::log((u.dot(moment * u) / moment.trace() + 1e-4) / (share + 1e-4)));
  }
  return std::max(0.0, sum - same_direction);
}

// Fills in how well what is held out matches what is wanted.
void compare(std::span<const Vec3> at, std::span<const Vec3> wanted, Division& division) {
  const std::vector<Vec3> held = displacements(at, division);
  const double found = median_length(held), farther = nearer(held, wanted);
  if (!std::isfinite(farther)) {
    division.mismatch = found;
    return;
  }
  const double directions = turned(held, wanted);
  division.mismatch = std::abs(farther) + directions;
  division.alike = std::max(0.0, farther) + directions <= std::log(most_mismatch);
}

std::optional<Division> natural_of(std::span<const Vec3> at, const std::vector<PositionGroups>& levels,
                                   std::span<const Vec3> wanted) {
  std::optional<Division> best;
  double least = std::numeric_limits<double>::infinity();
  for (const PositionGroups& level : levels) {
    Division division = divide(at, level);
    if (division.count == 0) continue;
    if (wanted.empty()) return division;
    const double off = nearer(displacements(at, division), wanted);
    if (off > std::log(most_mismatch) || off < -std::log(most_farther) || std::abs(off) >= least) continue;
    least = std::abs(off);
    best = std::move(division);
  }
  return best;
}

}  // namespace

bool Division::fits() const {
  return mismatch <= std::log(most_mismatch);
}

std::optional<Division> natural_division(std::span<const Vec3> at, std::span<const Vec3> wanted) {
  return natural_of(at, natural_groups(at), wanted);
}

Division best_division(std::span<const Vec3> at, std::span<const Vec3> wanted) {
  std::vector<PositionGroups> ways = natural_groups(at);
  if (std::optional<Division> natural = natural_of(at, ways, wanted)) return *std::move(natural);
  if (wanted.empty()) return divide(at, compact_groups(at, 4));
  // From large to small groups: in a tie the larger is taken.
  std::vector<std::size_t> sizes{1};
  while (8 * sizes.back() <= at.size() / 2) sizes.push_back(2 * sizes.back());
  for (auto size = sizes.rbegin(); size != sizes.rend(); ++size) ways.push_back(compact_groups(at, *size));
  Division best;
  best.mismatch = std::numeric_limits<double>::infinity();
  for (PositionGroups& way : ways) {
    Division division = divide(at, std::move(way));
    if (division.count == 0) continue;
    compare(at, wanted, division);
    if (division.mismatch < best.mismatch) best = std::move(division);
  }
  return best;
}

}  // namespace forefeel
