#include "solver/system/pad_springs.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "solver/system/discretisation.hpp"

namespace forefeel {

double PadSprings::energy(const double* u) const {
  double twice = 0;
  for (const Pair& p : pairs) {
    const double *a = u + 3 * p.a, *b = u + 3 * p.b;
    const double product = p.stiffness * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
    twice += p.a == p.b ? product : 2 * product;
  }
  return 0.5 * twice;
}

void PadSprings::apply(const double* u, double* y) const {
  for (const Pair& p : pairs)
    for (std::int32_t i = 0; i < 3; ++i) {
      *(y + 3 * p.a + i) += p.stiffness * *(u + 3 * p.b + i);
      if (p.a != p.b) *(y + 3 * p.b + i) += p.stiffness * *(u + 3 * p.a + i);
    }
}

void PadSprings::apply_lanes(const double* u, double* y) const {
  constexpr std::int32_t row = 3 * lane_count;
  for (const Pair& p : pairs)
    for (std::int32_t i = 0; i < row; ++i) {
      *(y + row * p.a + i) += p.stiffness * *(u + row * p.b + i);
      if (p.a != p.b) *(y + row * p.b + i) += p.stiffness * *(u + row * p.a + i);
    }
}

void PadSprings::energy_lanes(const double* u, double* energy) const {
  constexpr std::int32_t row = 3 * lane_count;
  for (const Pair& p : pairs) {
    const double scale = p.a == p.b ? 0.5 * p.stiffness : p.stiffness;
    for (std::int32_t i = 0; i < row; ++i)
      *(energy + i % lane_count) += scale * *(u + row * p.a + i) * *(u + row * p.b + i);
  }
}

void PadSprings::add_to(double* blocks) const {
  for (const Pair& p : pairs)
    for (std::int64_t i = 0; i < 3; ++i) *(blocks + 9 * p.block + 4 * i) += p.stiffness;
}

namespace {

// Nodes of the elements at the corners of a facet and at the middles of its edges.
std::array<NodeIndex, 6> nodes_of(const PadFacet& facet,
                                  const std::map<std::array<NodeIndex, 2>, NodeIndex>& middle) {
  std::array<NodeIndex, 6> nodes{facet.corners[0], facet.corners[1], facet.corners[2]};
  if (facet.nodes == 6)
    for (std::size_t e = 0; e < 3; ++e) {
      const NodeIndex a = facet.corners[e], b = facet.corners[(e + 1) % 3];
      nodes[3 + e] = middle.at({std::min(a, b), std::max(a, b)});
    }
  return nodes;
}

}  // namespace

PadSprings pad_springs(const Body& body, const Discretisation& d) {
  PadSprings springs;
  if (!body.pad) return springs;
  std::map<std::array<NodeIndex, 2>, NodeIndex> middle;
  const auto corners = static_cast<NodeIndex>(body.mesh.nodes.size());
  for (std::size_t e = 0; e < d.edges.size(); ++e) middle[d.edges[e]] = corners + static_cast<NodeIndex>(e);
  const auto tip = static_cast<std::int32_t>(d.free_nodes), clamp = tip + 1;
  std::map<std::pair<std::int32_t, std::int32_t>, double> sums;
  const auto add = [&](std::int32_t a, std::int32_t b, double value) {
    if (a != clamp && b != clamp && a <= b) sums[{a, b}] += value;
  };
  for (const PadFacet& facet : pad_surface(body.mesh, *body.pad, d.edges.empty() ? 3 : 6).facets) {
    const std::array<NodeIndex, 6> nodes = nodes_of(facet, middle);
    const auto count = static_cast<std::size_t>(facet.nodes);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j) {
        const std::int32_t a = d.local[nodes[i]], b = d.local[nodes[j]];
        const double value = facet.springs[i][j];
        add(a, b, value);
        add(a, tip, -value);
        add(tip, tip, value);
      }
  }
  for (const auto& [pair, value] : sums) springs.pairs.push_back({pair.first, pair.second, 0, value});
  return springs;
}

}  // namespace forefeel
