#include "solver/body/refined_body.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace forefeel {
namespace {

// The nodes in the middle of the edges, made when they are first asked for.
class Middles {
 public:
  explicit Middles(TetMesh& mesh) : mesh_(mesh) {}

  NodeIndex of(NodeIndex a, NodeIndex b) {
    const auto [at, fresh] = nodes_.emplace(std::array{std::min(a, b), std::max(a, b)},
                                            static_cast<NodeIndex>(mesh_.nodes.size()));
    if (fresh) {
      const Vec3 middle = 0.5 * (mesh_.nodes[a] + mesh_.nodes[b]);
      mesh_.nodes.push_back(middle);
    }
    return at->second;
  }

  void complete(std::vector<NodeIndex>& set) const {
    const std::vector<NodeIndex> corners = set;
    for (const auto& [edge, node] : nodes_)
      if (std::ranges::binary_search(corners, edge[0]) && std::ranges::binary_search(corners, edge[1]))
        set.push_back(node);
    std::ranges::sort(set);
  }

 private:
  TetMesh& mesh_;
  std::map<std::array<NodeIndex, 2>, NodeIndex> nodes_;
};

// The inner octahedron is cut along the diagonal from the middle of edge 02 to that of edge 13.
void split(const Tet& t, Middles& middles, std::vector<Tet>& into) {
  const NodeIndex m01 = middles.of(t[0], t[1]), m02 = middles.of(t[0], t[2]), m03 = middles.of(t[0], t[3]);
  const NodeIndex m12 = middles.of(t[1], t[2]), m13 = middles.of(t[1], t[3]), m23 = middles.of(t[2], t[3]);
  for (const Tet& part : {Tet{t[0], m01, m02, m03}, Tet{m01, t[1], m12, m13}, Tet{m02, m12, t[2], m23},
                          Tet{m03, m13, m23, t[3]}, Tet{m01, m02, m03, m13}, Tet{m01, m12, m02, m13},
                          Tet{m02, m03, m13, m23}, Tet{m02, m13, m12, m23}})
    into.push_back(part);
}

}  // namespace

Body refined(const Body& body) {
  Body fine = body;
  fine.fine.reset();
  fine.mesh.tets.clear();
  fine.mesh.groups.clear();
  fine.mesh.element_groups.clear();
  Middles middles(fine.mesh);
  for (const Tet& tet : body.mesh.tets) split(tet, middles, fine.mesh.tets);
  middles.complete(fine.clamp);
  middles.complete(fine.contact);
  for (MaterialRegion& region : fine.regions) {
    const std::vector<TetIndex> whole = std::exchange(region.tets, {});
    for (const TetIndex tet : whole)
      for (TetIndex part = 0; part < 8; ++part) region.tets.push_back(8 * tet + part);
  }
  return fine;
}

std::int64_t estimated_nodes(const Body& body) {
  const auto corners = static_cast<std::int64_t>(body.mesh.nodes.size());
  const auto tets = static_cast<std::int64_t>(body.mesh.tets.size());
  return body.element == Element::linear ? corners : 2 * corners + tets;
}

std::int64_t estimated_nodes_refined(const Body& body) {
  const auto corners = static_cast<std::int64_t>(body.mesh.nodes.size());
  const auto tets = static_cast<std::int64_t>(body.mesh.tets.size());
  const std::int64_t fine_corners = 2 * corners + tets;  // corners and edges
  // Each edge in two, three in each face, one in each octahedron.
  const std::int64_t fine_edges = 2 * (corners + tets) + 3 * 2 * tets + tets;
  return body.element == Element::linear ? fine_corners : fine_corners + fine_edges;
}

}  // namespace forefeel
