#include "geometry/meshing/tet_improve.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <unordered_map>

namespace forefeel {
namespace {

constexpr int improvements = 4;
constexpr double peel_below_deg =
    6;  // a flat tetrahedron on the surface is removed below this dihedral angle
constexpr unsigned faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};  // outward, opposite node i

// Least sine of a dihedral angle; negative for an inverted tetrahedron. The sine penalises angles near 0 and near 180
// degrees alike and needs no trigonometry: sin = 3/2 V l / (A_i A_j), with l the edge that the two faces share.
double volume_shape(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 p[4] = {a, b, c, d};
  const double six_volume = (b - a).cross(c - a).dot(d - a);
  double area[4];
  for (int i = 0; i < 4; ++i)
    area[i] = (p[faces[i][1]] - p[faces[i][0]]).cross(p[faces[i][2]] - p[faces[i][0]]).norm();
  double least = 1;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      int other[2], n = 0;
      for (int k = 0; k < 4; ++k)
        if (k != i && k != j) other[n++] = k;
      const double product = area[i] * area[j];
      least = std::min(least, product > 0 ? six_volume * (p[other[0]] - p[other[1]]).norm() / product : -1);
    }
  return least;
}

using Key = std::uint64_t;
Key face_key(NodeIndex a, NodeIndex b, NodeIndex c) {  // up to two million nodes
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return static_cast<Key>(a) << 42 | static_cast<Key>(b) << 21 | static_cast<Key>(c);
}
Key edge_key(NodeIndex a, NodeIndex b) {
  return static_cast<Key>(std::min(a, b)) << 32 | static_cast<Key>(std::max(a, b));
}

class Improver {
 public:
  Improver(TetMesh& mesh, const ImproveOptions& options) : mesh_(mesh), options_(options) {}

  void run() {
    if (mesh_.nodes.size() >= (1u << 21)) return;
    if (!options_.flips) {
      for (int k = 0; k < 3 * improvements; ++k) smooth();
      return;
    }
    for (int round = 0; round < improvements; ++round) {
      while (peel()) {
      }
      flip_faces();
      flip_edges();
      for (int k = 0; k < 3; ++k) smooth();
    }
    while (peel()) {
    }
    drop_unused_nodes(mesh_, 0);
  }

 private:
  const Vec3& at(NodeIndex i) const { return mesh_.nodes[i]; }
  double shape_of(const Tet& t) const { return volume_shape(at(t[0]), at(t[1]), at(t[2]), at(t[3])); }

  struct Side {
    Key key;
    TetIndex tet;
    unsigned side;
  };
  std::vector<Side> sides() const {
    std::vector<Side> result;
    result.reserve(4 * mesh_.tets.size());
    for (TetIndex t = 0; t < mesh_.tets.size(); ++t)
      for (unsigned side = 0; side < 4; ++side) {
        const Tet& tet = mesh_.tets[t];
        result.push_back({face_key(tet[faces[side][0]], tet[faces[side][1]], tet[faces[side][2]]), t, side});
      }
    std::ranges::sort(
        result, [](const Side& a, const Side& b) { return a.key != b.key ? a.key < b.key : a.tet < b.tet; });
    return result;
  }

  // Removes flat tetrahedra on the surface. With two faces there, the surface gets the other diagonal of the two; with
  // three faces, a low tip is cut off. The surface moves by less than a tenth of the edges there. True if any was
  // removed.
  bool peel() {
    const std::vector<Side> all = sides();
    std::vector<std::vector<unsigned>> outer(mesh_.tets.size());
    std::vector<Key> surface_edges;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const bool twin =
          (i > 0 && all[i - 1].key == all[i].key) || (i + 1 < all.size() && all[i + 1].key == all[i].key);
      if (twin) continue;
      outer[all[i].tet].push_back(all[i].side);
      const Tet& tet = mesh_.tets[all[i].tet];
      for (int k = 0; k < 3; ++k)
        surface_edges.push_back(edge_key(tet[faces[all[i].side][k]], tet[faces[all[i].side][(k + 1) % 3]]));
    }
    std::ranges::sort(surface_edges);
    const double limit = std::sin(peel_below_deg * std::numbers::pi / 180);
    std::vector<char> gone(mesh_.tets.size(), 0), busy(mesh_.nodes.size(), 0);
    bool any = false;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      if (outer[t].size() < 2 || outer[t].size() > 3) continue;
      const Tet& tet = mesh_.tets[t];
      if (shape_of(tet) > limit || std::ranges::any_of(tet, [&](NodeIndex node) { return busy[node] != 0; }))
        continue;
      // Two faces i and j: their common edge joins the other nodes, the new edge joins nodes i and j.
      const NodeIndex i = tet[outer[t][0]], j = tet[outer[t][1]];
      if (outer[t].size() == 2 && std::ranges::binary_search(surface_edges, edge_key(i, j))) continue;
      if (loses_held(tet, outer[t]) || !low(tet, outer[t])) continue;
      gone[t] = 1, any = true;
      for (const NodeIndex node : tet) busy[node] = 1;
    }
    if (any) erase(gone);
    return any;
  }

  bool is_held(std::size_t node) const { return node < options_.held.size() && options_.held[node] != 0; }

  // Whether the surface without this tetrahedron lacks a held node, or an edge between two of them.
  bool loses_held(const Tet& tet, const std::vector<unsigned>& on_surface) const {
    std::size_t held = 0;
    for (unsigned k = 0; k < 4; ++k)
      if (std::ranges::find(on_surface, k) == on_surface.end()) held += is_held(tet[k]);
    if (on_surface.size() == 2) return held == 2;  // the edge that both faces share
    return is_held(tet[6 - on_surface[0] - on_surface[1] - on_surface[2]]);
  }

  // Whether removing this tetrahedron hardly moves the surface: its faces on the surface have nearly one
  // normal (otherwise it is a real edge or tip of the body), and its height is small.
  bool low(const Tet& tet, const std::vector<unsigned>& on_surface) const {
    std::vector<Vec3> normals;
    for (const unsigned side : on_surface) {
      const Vec3& a = at(tet[faces[side][0]]);
      normals.push_back((at(tet[faces[side][1]]) - a).cross(at(tet[faces[side][2]]) - a).normalized());
    }
    for (std::size_t k = 1; k < normals.size(); ++k)
      if (normals[0].dot(normals[k]) < 0.5) return false;
    double shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) shortest = std::min(shortest, (at(tet[i]) - at(tet[j])).norm());
    const Vec3 a = at(tet[1]) - at(tet[0]), b = at(tet[2]) - at(tet[0]), c = at(tet[3]) - at(tet[0]);
    const double six_volume = a.cross(b).dot(c);
    double height = 0;
    if (on_surface.size() == 2) {  // distance between the old and the new edge
      const NodeIndex i = tet[on_surface[0]], j = tet[on_surface[1]];
      NodeIndex other[2]{}, n = 0;
      for (const NodeIndex node : tet)
        if (node != i && node != j) other[n++] = node;
      height = six_volume / (at(i) - at(j)).cross(at(other[0]) - at(other[1])).norm();
    } else {  // height of the tip over the inner face
      const unsigned inside = 6 - on_surface[0] - on_surface[1] - on_surface[2];
      const Vec3& p = at(tet[faces[inside][0]]);
      height = six_volume / (at(tet[faces[inside][1]]) - p).cross(at(tet[faces[inside][2]]) - p).norm();
    }
    return height < 0.1 * shortest;
  }

  void erase(const std::vector<char>& gone) {
    std::size_t kept = 0;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t)
      if (!gone[t]) mesh_.tets[kept++] = mesh_.tets[t];
    mesh_.tets.resize(kept);
  }

  // 2-3: two tetrahedra over a common face become three around the edge between their tops.
  void flip_faces() {
    const std::vector<Side> all = sides();
    std::vector<char> touched(mesh_.tets.size(), 0);
    std::vector<Tet> added;
    for (std::size_t i = 0; i + 1 < all.size(); ++i) {
      if (all[i].key != all[i + 1].key) continue;
      const TetIndex s = all[i].tet, t = all[i + 1].tet;
      if (touched[s] || touched[t]) continue;
      const Tet one = mesh_.tets[s], two = mesh_.tets[t];
      const NodeIndex top = two[all[i + 1].side], bottom = one[all[i].side];
      const unsigned* f = faces[all[i].side];  // outward from `one`, so towards top
      const NodeIndex a = one[f[0]], b = one[f[1]], c = one[f[2]];
      const double before = std::min(shape_of(one), shape_of(two));
      const std::array<Tet, 3> flipped{Tet{a, b, top, bottom}, Tet{b, c, top, bottom},
                                       Tet{c, a, top, bottom}};
      const std::array<Tet, 3> turned{Tet{a, b, bottom, top}, Tet{b, c, bottom, top}, Tet{c, a, bottom, top}};
      const std::array<Tet, 3>& best = shape_of(flipped[0]) > 0 ? flipped : turned;
      if (worst(best) <= before * 1.001 + 1e-9) continue;
      touched[s] = touched[t] = 1;
      mesh_.tets[s] = best[0], mesh_.tets[t] = best[1];
      added.push_back(best[2]);
    }
    mesh_.tets.insert(mesh_.tets.end(), added.begin(), added.end());
  }

  template <class Tets>
  double worst(const Tets& tets) const {
    double least = 1;
    for (const Tet& tet : tets) least = std::min(least, shape_of(tet));
    return least;
  }

  // Removes an inner edge with n tetrahedra around it: the ring of n nodes is triangulated, two tetrahedra
  // for each triangle (3-2 for n = 3, 4-4 for n = 4, and so on).
  void flip_edges() {
    std::unordered_map<Key, std::vector<TetIndex>> around;
    for (TetIndex t = 0; t < mesh_.tets.size(); ++t)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j)
          around[edge_key(mesh_.tets[t][i], mesh_.tets[t][j])].push_back(t);
    std::vector<Key> order;
    order.reserve(around.size());
    for (const auto& [key, tets] : around)
      if (tets.size() >= 3 && tets.size() <= 7) order.push_back(key);
    std::ranges::sort(order);  // the map's own order differs between libraries
    std::vector<char> touched(mesh_.tets.size(), 0), gone(mesh_.tets.size(), 0);
    for (const Key key : order) {
      const std::vector<TetIndex>& tets = around[key];
      if (std::ranges::any_of(tets, [&](TetIndex t) { return touched[t] != 0; })) continue;
      if (std::optional<std::vector<Tet>> better = remove_edge(
              static_cast<NodeIndex>(key >> 32), static_cast<NodeIndex>(key & 0xffffffff), tets)) {
        for (const TetIndex t : tets) touched[t] = 1, gone[t] = 1;
        for (std::size_t k = 0; k < better->size(); ++k) {
          if (k < tets.size())
            mesh_.tets[tets[k]] = (*better)[k], gone[tets[k]] = 0;
          else
            extra_.push_back((*better)[k]);
        }
      }
    }
    erase(gone);
    mesh_.tets.insert(mesh_.tets.end(), extra_.begin(), extra_.end());
    extra_.clear();
  }

  // The nodes around edge (p, q) in order; empty where the ring is open (the edge lies on the surface).
  std::vector<NodeIndex> ring(NodeIndex p, NodeIndex q, const std::vector<TetIndex>& tets) const {
    std::vector<std::pair<NodeIndex, NodeIndex>> links;
    for (const TetIndex t : tets) {
      NodeIndex other[2]{}, n = 0;
      for (const NodeIndex node : mesh_.tets[t])
        if (node != p && node != q) other[n++] = node;
      links.emplace_back(other[0], other[1]);
    }
    std::vector<NodeIndex> result{links[0].first, links[0].second};
    std::vector<char> used(links.size(), 0);
    used[0] = 1;
    for (std::size_t step = 1; step < links.size(); ++step) {
      bool found = false;
      for (std::size_t k = 0; k < links.size() && !found; ++k) {
        if (used[k] || (links[k].first != result.back() && links[k].second != result.back())) continue;
        result.push_back(links[k].first == result.back() ? links[k].second : links[k].first);
        used[k] = 1, found = true;
      }
      if (!found) return {};
    }
    if (result.back() != result.front()) return {};
    result.pop_back();
    return result;
  }

  std::optional<std::vector<Tet>> remove_edge(NodeIndex p, NodeIndex q,
                                              const std::vector<TetIndex>& tets) const {
    const std::vector<NodeIndex> nodes = ring(p, q, tets);
    const std::size_t n = nodes.size();
    if (n < 3) return std::nullopt;
    double before = 1;
    for (const TetIndex t : tets) before = std::min(before, shape_of(mesh_.tets[t]));
    if (before > 0.5) return std::nullopt;  // 30 degrees: good enough
    const bool upward =
        volume_shape(at(nodes[0]), at(nodes[1]), at(p), at(q)) > 0;  // ring turns about p -> q
    const auto pair_of = [&](std::size_t i, std::size_t k, std::size_t j) {
      const NodeIndex a = nodes[i], b = nodes[k], c = nodes[j];
      return upward ? std::array<Tet, 2>{Tet{a, b, c, q}, Tet{a, c, b, p}}
                    : std::array<Tet, 2>{Tet{a, b, c, p}, Tet{a, c, b, q}};
    };
    // Best triangulation of the ring by dynamic programming (Klincsek): best(i, j) of the polygon i..j.
    double best[8][8];
    std::size_t split[8][8]{};
    for (std::size_t gap = 1; gap < n; ++gap)
      for (std::size_t i = 0; i + gap < n; ++i) {
        const std::size_t j = i + gap;
        best[i][j] = gap == 1 ? 1.0 : -2.0;
        for (std::size_t k = i + 1; k < j; ++k) {
          const double value = std::min({worst(pair_of(i, k, j)), best[i][k], best[k][j]});
          if (value > best[i][j]) best[i][j] = value, split[i][j] = k;
        }
      }
    if (best[0][n - 1] <= before * 1.001 + 1e-9) return std::nullopt;
    std::vector<Tet> result;
    collect(0, n - 1, split, pair_of, result);
    return result;
  }

  template <class Pair>
  static void collect(std::size_t i, std::size_t j, const std::size_t (&split)[8][8], const Pair& pair_of,
                      std::vector<Tet>& out) {
    if (j - i < 2) return;
    const std::size_t k = split[i][j];
    for (const Tet& tet : pair_of(i, k, j)) out.push_back(tet);
    collect(i, k, split, pair_of, out);
    collect(k, j, split, pair_of, out);
  }

  // Tries steps of inner nodes towards the mean of their neighbours and along the axes; the step is halved
  // until nothing helps. Nodes of the surface move only next to very bad tetrahedra, by a few hundredths of
  // an edge.
  void smooth() {
    std::vector<std::vector<TetIndex>> star(mesh_.nodes.size());
    for (TetIndex t = 0; t < mesh_.tets.size(); ++t)
      for (const NodeIndex node : mesh_.tets[t]) star[node].push_back(t);
    for (std::size_t i = 0; i < mesh_.nodes.size(); ++i)
      if (!star[i].empty() && !is_held(i)) move(i, star[i], i < options_.fixed_nodes);
  }

  double worst_around(const std::vector<TetIndex>& star) const {
    double least = 1;
    for (const TetIndex t : star) least = std::min(least, shape_of(mesh_.tets[t]));
    return least;
  }

  bool attempt(std::size_t i, const std::vector<TetIndex>& star, const Vec3& target, double& value) {
    const Vec3 old = mesh_.nodes[i];
    mesh_.nodes[i] = target;
    const double now = worst_around(star);
    if (now > value) return value = now, true;
    mesh_.nodes[i] = old;
    return false;
  }

  Vec3 allowed(const Vec3& place, bool on_surface) const {
    return on_surface && options_.onto ? options_.onto(place) : place;
  }

  void move(std::size_t i, const std::vector<TetIndex>& star, bool on_surface) {
    double value = worst_around(star);
    if (value > (on_surface ? 0.17 : 0.5)) return;  // sines of 10 and 30 degrees
    double longest = 0;
    Vec3 mean = Vec3::Zero();
    for (const TetIndex t : star)
      for (const NodeIndex node : mesh_.tets[t]) {
        longest = std::max(longest, (at(node) - mesh_.nodes[i]).norm());
        mean += (at(node) - mesh_.nodes[i]) / (3.0 * static_cast<double>(star.size()));
      }
    const Vec3 start = mesh_.nodes[i];
    for (const double share : {1.0, 0.5, 0.25})
      if (!on_surface) attempt(i, star, start + share * mean, value);
    for (double step = (on_surface ? 0.02 : 0.2) * longest; step > 0.004 * longest; step *= 0.5)
      for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0})
          if (attempt(i, star, allowed(mesh_.nodes[i] + sign * step * Vec3::Unit(axis), on_surface), value))
            break;
  }

  TetMesh& mesh_;
  const ImproveOptions& options_;
  std::vector<Tet> extra_;
};

}  // namespace

void improve_shapes(TetMesh& mesh, const ImproveOptions& options) {
  Improver(mesh, options).run();
}

void drop_unused_nodes(TetMesh& mesh, std::size_t keep) {
  std::vector<char> used(mesh.nodes.size(), 0);
  std::fill_n(used.begin(), std::min(keep, used.size()), char{1});
  for (const Tet& tet : mesh.tets)
    for (const NodeIndex node : tet) used[node] = 1;
  std::vector<NodeIndex> number(mesh.nodes.size(), no_node);
  NodeIndex next = 0;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) mesh.nodes[next] = mesh.nodes[i], number[i] = next++;
  mesh.nodes.resize(static_cast<std::size_t>(next));
  for (Tet& tet : mesh.tets)
    for (NodeIndex& node : tet) node = number[node];
}

}  // namespace forefeel
