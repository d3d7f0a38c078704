#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include "solver/discretisation.hpp"

namespace forefeel {

std::vector<std::int32_t> elimination_order(const std::vector<std::vector<std::int32_t>>& adjacency,
                                            const std::vector<Vec3>&) {
  const auto n = static_cast<int>(adjacency.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 1.0);
    for (const std::int32_t j : adjacency[static_cast<std::size_t>(i)]) entries.emplace_back(i, j, 1.0);
  }
  Eigen::SparseMatrix<double> graph(n, n);
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> inverse;
  Eigen::AMDOrdering<int>{}(graph, inverse);
  return {inverse.indices().data(), inverse.indices().data() + n};
}

}  // namespace forefeel
