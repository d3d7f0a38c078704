#include "approx/measured/position_groups.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "geometry/common/dense.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/common/union_find.hpp"

namespace forefeel {
namespace {

constexpr double least_jump = 1.5;       // of edge lengths, between clusters and within them
constexpr double least_jump_of_few = 3;  // with fewer than six clusters
constexpr std::size_t most_levels = 3;   // of clusters: presses, and rows held at one depth of a press
constexpr std::size_t compact_size = 4;  // positions of a compact group
constexpr double wide_gap = 0.25;        // between two positions, in the side of their box
constexpr double same_direction = 0.3;   // mismatch of directions that counts as none
constexpr double most_mismatch = 2.5;    // ratio of distances and directions, up to which groups fit
constexpr double most_farther = 4;       // of natural groups, in distances of the places
constexpr std::size_t most_parts = 8;
constexpr std::size_t enough = 2000;  // positions that tell their distances

struct Edge {
  double length;
  std::uint32_t a, b;
};

// Minimum spanning tree (Prim), edges by increasing length.
std::vector<Edge> spanning_tree(std::span<const Vec3> positions) {
  const std::size_t n = positions.size();
  std::vector<double> away(n, std::numeric_limits<double>::infinity());
  std::vector<std::uint32_t> from(n, 0);
  std::vector<char> in(n, 0);
  std::vector<Edge> edges;
  std::size_t last = 0;
  for (std::size_t step = 1; step < n; ++step) {
    in[last] = 1;
    std::size_t next = n;
    for (std::size_t i = 0; i < n; ++i) {
      if (in[i]) continue;
      const double d = (positions[i] - positions[last]).norm();
      if (d < away[i]) away[i] = d, from[i] = static_cast<std::uint32_t>(last);
      if (next == n || away[i] < away[next]) next = i;
    }
    edges.push_back({away[next], from[next], static_cast<std::uint32_t>(next)});
    last = next;
  }
  std::ranges::stable_sort(edges, {}, &Edge::length);
  return edges;
}

// Numbers of the shorter edges that join positions of one cluster, by falling jump. A cluster holds at least two
// positions on average. There are at least six, or three that are far from each other.
std::vector<std::size_t> joining_edges(const std::vector<Edge>& edges) {
  const std::size_t n = edges.size() + 1;
  std::vector<std::pair<double, std::size_t>> jumps;
  for (std::size_t k = std::max<std::size_t>(1, n / 2); k < edges.size() && k + 2 < n;
       ++k) {  // n - k clusters
    const double jump = edges[k].length / std::max(edges[k - 1].length, std::numeric_limits<double>::min());
    if (jump >= (k + 5 < n ? least_jump : least_jump_of_few)) jumps.emplace_back(-jump, k);
  }
  std::ranges::sort(jumps);
  if (jumps.size() > most_levels) jumps.resize(most_levels);
  std::vector<std::size_t> joining;
  for (const auto& jump : jumps) joining.push_back(jump.second);
  return joining;
}

// Where to split positions sorted along the longest side of their box: in the middle, or at a gap near it, as between
// two lines of a raster, whose rows are then of one box only if they are of one line.
std::size_t split_of(std::span<const Vec3> positions, std::span<const std::size_t> order, Eigen::Index axis,
                     double side) {
  const std::size_t middle = order.size() / 2, apart = std::max<std::size_t>(1, order.size() / 4);
  std::size_t found = middle;
  double widest = wide_gap * side;
  for (std::size_t k = apart; k + apart <= order.size(); ++k)
    if (const double gap = positions[order[k]][axis] - positions[order[k - 1]][axis]; gap > widest) {
      widest = gap;
      found = k;
    }
  return found;
}

// Splits `order` along the longest side of its box, in the middle or at gaps, until it is small.
void halve(std::span<const Vec3> positions, std::span<std::size_t> order, std::size_t most, bool at_gaps,
           PositionGroups& groups) {
  if (order.size() <= most) {
    for (const std::size_t i : order) groups.of[i] = static_cast<std::uint32_t>(groups.count);
    ++groups.count;
    return;
  }
  Box box{positions[order[0]], positions[order[0]]};
  for (const std::size_t i : order) box = {box.low.cwiseMin(positions[i]), box.high.cwiseMax(positions[i])};
  Eigen::Index axis = 0;
  const double side = box.size().maxCoeff(&axis);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return positions[i][axis]; });
  const std::size_t split = at_gaps ? split_of(positions, order, axis, side) : order.size() / 2;
  halve(positions, order.first(split), most, at_gaps, groups);
  halve(positions, order.subspan(split), most, at_gaps, groups);
}

}  // namespace

PositionGroups compact_groups(std::span<const Vec3> positions, std::size_t most, bool at_gaps) {
  PositionGroups groups;
  groups.of.assign(positions.size(), 0);
  if (positions.empty()) return groups;
  std::vector<std::size_t> order(positions.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  halve(positions, order, std::max<std::size_t>(most, 1), at_gaps, groups);
  return groups;
}

std::vector<PositionGroups> natural_groups(std::span<const Vec3> positions) {
  const std::size_t n = positions.size();
  if (n == 0) return {};
  const std::vector<Edge> edges = spanning_tree(positions);
  std::vector<PositionGroups> levels;
  for (const std::size_t joining : joining_edges(edges)) {
    PositionGroups groups;
    groups.of.assign(n, 0);
    groups.natural = true;
    UnionFind sets(n);
    for (std::size_t k = 0; k < joining; ++k) sets.join(edges[k].a, edges[k].b);
    std::vector<std::uint32_t> number(n, std::numeric_limits<std::uint32_t>::max());
    for (std::size_t i = 0; i < n; ++i) {
      std::uint32_t& own = number[sets.find(static_cast<std::uint32_t>(i))];
      if (own == std::numeric_limits<std::uint32_t>::max()) own = static_cast<std::uint32_t>(groups.count++);
      groups.of[i] = own;
    }
    levels.push_back(std::move(groups));
  }
  return levels;
}

PositionGroups position_groups(std::span<const Vec3> positions) {
  std::vector<PositionGroups> levels = natural_groups(positions);
  return levels.empty() ? compact_groups(positions, compact_size) : std::move(levels.front());
}

// Each group in turn takes the part whose groups lie farthest from it, among the parts with the fewest
// groups.
std::vector<std::uint32_t> spread_over_parts(std::span<const Vec3> positions, const PositionGroups& groups,
                                             std::size_t parts) {
  std::vector<Vec3> centre(groups.count, Vec3::Zero());
  std::vector<std::size_t> size(groups.count, 0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    centre[groups.of[i]] += positions[i];
    ++size[groups.of[i]];
  }
  for (std::size_t g = 0; g < groups.count; ++g) centre[g] /= static_cast<double>(size[g]);
  std::vector<std::uint32_t> part(groups.count, 0);
  std::vector<std::vector<std::size_t>> held(parts);
  for (std::size_t g = 0; g < groups.count; ++g) {
    std::size_t fewest = held[0].size();
    for (const auto& of : held) fewest = std::min(fewest, of.size());
    double farthest = -1;
    for (std::size_t p = 0; p < parts; ++p) {
      if (held[p].size() > fewest) continue;
      double away = std::numeric_limits<double>::max();
      for (const std::size_t other : held[p])
        away = std::min(away, (centre[other] - centre[g]).squaredNorm());
      if (away > farthest) farthest = away, part[g] = static_cast<std::uint32_t>(p);
    }
    held[part[g]].push_back(g);
  }
  return part;
}

namespace {

Division divide(std::span<const Vec3> at, PositionGroups groups) {
  Division division{.groups = std::move(groups), .part = {}};
  if (division.groups.count < 3) return division;
  division.count = std::min(most_parts, division.groups.count);
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
