#include "approx/measured/position_groups.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "geometry/common/union_find.hpp"

namespace forefeel {
namespace {

constexpr double least_jump = 1.5;       // of edge lengths, between clusters and within them
constexpr double least_jump_of_few = 3;  // with fewer than six clusters
constexpr std::size_t most_levels = 3;   // of clusters: presses, and rows held at one depth of a press
constexpr std::size_t compact_size = 4;  // positions of a compact group
constexpr double wide_gap = 0.25;        // between two positions, in the side of their box

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

}  // namespace forefeel
