#include "solver/system/discretisation.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "solver/body/law.hpp"
#include "solver/body/pad.hpp"
#include "solver/system/ordering.hpp"

namespace forefeel {
namespace {

constexpr std::array<std::array<unsigned, 2>, 6> tet_edges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

// Nodes of each element: the corners, then (quadratic) the midpoints of the edges.
std::vector<NodeIndex> connect(const Body& body, std::vector<std::array<NodeIndex, 2>>& edges) {
  const bool quadratic = body.element == Element::quadratic;
  std::vector<NodeIndex> nodes;
  std::map<std::array<NodeIndex, 2>, NodeIndex> known;
  for (const Tet& tet : body.mesh.tets) {
    nodes.insert(nodes.end(), tet.begin(), tet.end());
    if (!quadratic) continue;
    for (const auto& [a, b] : tet_edges) {
      const std::array<NodeIndex, 2> edge{std::min(tet[a], tet[b]), std::max(tet[a], tet[b])};
      const auto fresh = static_cast<NodeIndex>(body.mesh.nodes.size() + edges.size());
      const auto [at, added] = known.emplace(edge, fresh);
      if (added) edges.push_back(edge);
      nodes.push_back(at->second);
    }
  }
  return nodes;
}

// The nodes of a set, and the mid-edge nodes between two of them.
std::vector<char> members(const std::vector<NodeIndex>& set, const Discretisation& d) {
  std::vector<char> in(static_cast<std::size_t>(d.nodes), 0);
  for (const NodeIndex node : set) in[node] = 1;
  const std::size_t first = in.size() - d.edges.size();
  for (std::size_t e = 0; e < d.edges.size(); ++e) in[first + e] = in[d.edges[e][0]] && in[d.edges[e][1]];
  return in;
}

void number_nodes(const Body& body, const std::vector<NodeIndex>& elements, Discretisation& d) {
  const std::vector<char> clamped = members(body.clamp, d), touched = members(body.contact, d);
  const std::size_t per_element = static_cast<std::size_t>(d.elements.nodes_per_element);
  std::vector<char> used(clamped.size(), 0);
  for (const NodeIndex node : elements) used[node] = 1;
  constexpr std::uint32_t none = ~std::uint32_t{0};  // of a node that is not free
  std::vector<std::uint32_t> number(clamped.size(), none);
  std::vector<Vec3> positions;
  for (std::size_t node = 0; node < number.size(); ++node) {
    if (!used[node] || clamped[node] || touched[node]) continue;
    number[node] = static_cast<std::uint32_t>(positions.size());
    const std::size_t corners = body.mesh.nodes.size();
    positions.push_back(node < corners ? body.mesh.nodes[node]
                                       : Vec3(0.5 * (body.mesh.nodes[d.edges[node - corners][0]] +
                                                     body.mesh.nodes[d.edges[node - corners][1]])));
  }
  std::vector<std::vector<std::uint32_t>> adjacency(positions.size());
  for (std::size_t first = 0; first < elements.size(); first += per_element)
    for (std::size_t a = 0; a < per_element; ++a)
      for (std::size_t b = 0; b < per_element; ++b) {
        const std::uint32_t i = number[elements[first + a]], j = number[elements[first + b]];
        if (i != none && j != none && i != j) adjacency[i].push_back(j);
      }
  for (auto& list : adjacency) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  const std::vector<std::uint32_t> order = elimination_order(adjacency, positions);
  std::vector<std::int32_t> rank(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<std::int32_t>(i);
  d.free_nodes = static_cast<std::int64_t>(order.size());
  d.local.resize(number.size());
  for (std::size_t node = 0; node < number.size(); ++node) {
    d.local[node] = static_cast<std::int32_t>(d.free_nodes + 1);
    if (number[node] != none) d.local[node] = rank[number[node]];
    if (touched[node]) d.local[node] = static_cast<std::int32_t>(d.free_nodes);
  }
}

// Elements that lie together come together, so that the ranges of groups that threads share meet in few nodes. A small
// body keeps its order: it is not shared.
void sort_by_elimination(const std::vector<NodeIndex>& elements, const Discretisation& d,
                         std::vector<TetIndex>& tets) {
  const auto per_element = static_cast<std::size_t>(d.elements.nodes_per_element);
  if (!d.elements.is_large()) return;
  const auto first_out = [&](TetIndex tet) {
    const auto* nodes = &elements[tet * per_element];
    std::int32_t least = d.local[nodes[0]];
    for (std::size_t a = 1; a < per_element; ++a) least = std::min(least, d.local[nodes[a]]);
    return least;
  };
  std::ranges::stable_sort(tets, {}, first_out);
}

// Element e of the connectivity into one lane of one group.
void fill_lane(const Body& body, const NodeIndex* nodes, std::size_t e, std::size_t at, Discretisation& d) {
  ElementGroups& to = d.elements;
  const auto per_element = static_cast<std::size_t>(to.nodes_per_element);
  const std::size_t group = at / lane_count, lane = at % lane_count;
  for (std::size_t a = 0; a < per_element; ++a)
    to.node[(group * per_element + a) * lane_count + lane] = d.local[nodes[a]];
  const Tet& tet = body.mesh.tets[e];
  Mat3 sides;
  for (unsigned i = 0; i < 3; ++i) sides.col(i) = body.mesh.nodes[tet[i + 1]] - body.mesh.nodes[tet[0]];
  const Mat3 inverse = sides.inverse();  // rows: gradients of barycentric coordinates 1 to 3
  Eigen::Matrix<double, 4, 3> gradients;
  gradients.row(0) = -inverse.colwise().sum();
  gradients.bottomRows<3>() = inverse;
  for (unsigned a = 0; a < 4; ++a)
    for (unsigned i = 0; i < 3; ++i)
      to.gradient_of_node[(group * 12 + 3 * a + i) * lane_count + lane] = gradients(a, i);
  to.volume[group * lane_count + lane] = sides.determinant() / 6;
}

void fill_groups(const Body& body, const std::vector<NodeIndex>& elements,
                 const std::vector<MaterialPart>& parts, Discretisation& d) {
  ElementGroups& to = d.elements;
  const auto per_element = static_cast<std::size_t>(to.nodes_per_element);
  std::size_t groups = 0;
  for (const MaterialGroups& of : to.materials) groups += static_cast<std::size_t>(of.count);
  to.node.assign(groups * per_element * lane_count, static_cast<std::int32_t>(d.free_nodes + 1));
  to.gradient_of_node.assign(groups * 12 * lane_count, 0.0);
  to.volume.assign(groups * lane_count, 0.0);
  for (std::size_t m = 0; m < parts.size(); ++m) {
    std::size_t at = static_cast<std::size_t>(to.materials[m].first) * lane_count;
    for (const TetIndex tet : parts[m].tets) fill_lane(body, &elements[tet * per_element], tet, at++, d);
  }
}

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

void fill_pattern(Discretisation& d) {
  const std::size_t per_element = static_cast<std::size_t>(d.elements.nodes_per_element);
  const std::size_t groups = d.elements.count(), pairs = per_element * (per_element + 1) / 2;
  const auto clamp = static_cast<std::uint32_t>(d.free_nodes + 1);
  std::vector<std::vector<std::uint32_t>> rows(clamp);
  for (std::uint32_t i = 0; i < clamp; ++i) rows[i].push_back(i);
  const auto at = [&](std::size_t group, std::size_t a, std::size_t lane) {
    return static_cast<std::uint32_t>(d.elements.node[(group * per_element + a) * lane_count + lane]);
  };
  for (std::size_t group = 0; group < groups; ++group)
    for (std::size_t lane = 0; lane < lane_count; ++lane)
      for (std::size_t b = 0; b < per_element; ++b)
        for (std::size_t a = 0; a <= b; ++a) {
          const std::uint32_t i = at(group, a, lane), j = at(group, b, lane);
          if (i != clamp && j != clamp) rows[std::min(i, j)].push_back(std::max(i, j));
        }
  for (const PadSprings::Pair& pair : d.elements.pad.pairs)
    rows[static_cast<std::size_t>(pair.a)].push_back(static_cast<std::uint32_t>(pair.b));
  d.pattern.row_start.assign(1, 0);
  for (auto& row : rows) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    d.pattern.column.insert(d.pattern.column.end(), row.begin(), row.end());
    d.pattern.row_start.push_back(d.pattern.size());
  }
  d.elements.block.assign(groups * pairs * lane_count, static_cast<std::int32_t>(d.pattern.size()));
  d.elements.block_kind.assign(groups * pairs * lane_count, 0);
  for (std::size_t group = 0; group < groups; ++group)
    for (std::size_t lane = 0; lane < lane_count; ++lane)
      for (std::size_t b = 0; b < per_element; ++b)
        for (std::size_t a = 0; a <= b; ++a) {
          const std::uint32_t i = at(group, a, lane), j = at(group, b, lane);
          if (i == clamp || j == clamp) continue;
          const std::size_t slot = (group * pairs + b * (b + 1) / 2 + a) * lane_count + lane;
          d.elements.block[slot] = static_cast<std::int32_t>(d.pattern.block(std::min(i, j), std::max(i, j)));
          d.elements.block_kind[slot] = static_cast<std::int8_t>(a != b && i == j ? 2 : i > j ? 1 : 0);
        }
  d.elements.fine.block = d.pattern.size() - 1;  // the contact's own, the last
  for (PadSprings::Pair& pair : d.elements.pad.pairs)
    pair.block = d.pattern.block(static_cast<std::uint32_t>(pair.a), static_cast<std::uint32_t>(pair.b));
}

}  // namespace

std::int64_t BlockPattern::block(std::uint32_t i, std::uint32_t j) const {
  return &*std::ranges::lower_bound(row(i), j) - column.data();
}

void Discretisation::to_local(const std::vector<double>& by_node, double* u) const {
  std::fill(u, u + local_size(), 0.0);
  const auto clamp = static_cast<std::int32_t>(free_nodes + 1);
  for (std::size_t node = 0; node < local.size(); ++node)
    if (local[node] != clamp)
      std::copy_n(&by_node[3 * node], 3, u + 3 * static_cast<std::int64_t>(local[node]));
}

std::vector<double> Discretisation::to_nodes(const double* u) const {
  std::vector<double> by_node(3 * local.size());
  for (std::size_t node = 0; node < local.size(); ++node)
    std::copy_n(u + 3 * static_cast<std::int64_t>(local[node]), 3, &by_node[3 * node]);
  return by_node;
}

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

Discretisation discretise(const Body& body) {
  Discretisation d;
  std::vector<MaterialPart> parts = material_parts(body);
  d.elements = empty_groups(body, parts);
  const std::vector<NodeIndex> elements = connect(body, d.edges);
  d.nodes = static_cast<std::int64_t>(body.mesh.nodes.size() + d.edges.size());
  number_nodes(body, elements, d);
  for (MaterialPart& part : parts) sort_by_elimination(elements, d, part.tets);
  fill_groups(body, elements, parts, d);
  d.elements.pad = pad_springs(body, d);
  d.elements.fine = {body.fine, d.free_nodes, 0};
  fill_pattern(d);
  d.elements.share();
  const double length = longest_side(body.mesh);
  for (const MaterialPart& part : parts) {
    const LawConstants moduli = law_constants(part.material);
    d.force_floor = std::max(d.force_floor, 1e-12 * part.material.young * length * length);
    d.round_off = std::max(d.round_off, 1e-16 * (std::abs(moduli.lambda) + 2 * moduli.mu) * length * length);
  }
  return d;
}

}  // namespace forefeel
