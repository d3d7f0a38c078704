#include "geometry/mesh/subdivided_mesh.hpp"

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

TetMesh subdivided(const TetMesh& mesh) {
  TetMesh fine = mesh;
  fine.tets.clear();
  Middles middles(fine);
  for (const Tet& tet : mesh.tets) split(tet, middles, fine.tets);
  for (auto& [name, nodes] : fine.groups) middles.complete(nodes);
  for (auto& [name, tets] : fine.element_groups) {
    const std::vector<TetIndex> whole = std::exchange(tets, {});
    for (const TetIndex tet : whole)
      for (TetIndex part = 0; part < 8; ++part) tets.push_back(8 * tet + part);
  }
  return fine;
}

}  // namespace forefeel
