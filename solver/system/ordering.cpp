#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

#include "solver/system/ordering.hpp"

namespace forefeel {
namespace {

using Graph = std::vector<std::vector<std::uint32_t>>;

constexpr std::uint32_t none = ~std::uint32_t{0};

std::vector<std::uint32_t> minimum_degree(const Graph& adjacency) {
  const auto n = static_cast<Eigen::Index>(adjacency.size());
  if (n == 0) return {};
  std::vector<Eigen::Triplet<double>> entries;
  for (std::uint32_t i = 0; i < adjacency.size(); ++i) {
    entries.emplace_back(i, i, 1.0);
    for (const std::uint32_t j : adjacency[i]) entries.emplace_back(i, j, 1.0);
  }
  Eigen::SparseMatrix<double> graph(n, n);
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> inverse;
  Eigen::AMDOrdering<int>{}(graph, inverse);
  return {inverse.indices().data(), inverse.indices().data() + n};
}

// Columns of the factor below the diagonal and the elimination tree, for nodes eliminated in `order`.
struct Elimination {
  std::vector<std::uint32_t> parent;  // by rank; none: root
  std::vector<std::int64_t> count;    // entries below the diagonal
  double flops = 0;
};

Elimination eliminate(const Graph& adjacency, const std::vector<std::uint32_t>& order) {
  const std::size_t n = order.size();
  std::vector<std::uint32_t> rank(n);
  for (std::size_t i = 0; i < n; ++i) rank[order[i]] = static_cast<std::uint32_t>(i);
  Elimination e{std::vector<std::uint32_t>(n, none), std::vector<std::int64_t>(n, 0), 0};
  std::vector<std::vector<std::uint32_t>> column(n), children(n);
  std::vector<std::size_t> mark(n, n);
  for (std::size_t j = 0; j < n; ++j) {
    const auto take = [&](std::uint32_t i) {
      if (i <= j || mark[i] == j) return;
      mark[i] = j;
      column[j].push_back(i);
    };
    for (const std::uint32_t node : adjacency[order[j]]) take(rank[node]);
    for (const std::uint32_t child : children[j]) {
      for (const std::uint32_t i : column[child]) take(i);
      std::vector<std::uint32_t>().swap(column[child]);
    }
    e.count[j] = static_cast<std::int64_t>(column[j].size());
    e.flops += 27.0 * static_cast<double>((e.count[j] + 1) * (e.count[j] + 1));
    if (column[j].empty()) continue;
    e.parent[j] = *std::min_element(column[j].begin(), column[j].end());
    children[e.parent[j]].push_back(static_cast<std::uint32_t>(j));
  }
  return e;
}

// Children before parents, the one with the longest column last, so that it can share its parent's front.
std::vector<std::uint32_t> postorder(const Elimination& e, const std::vector<std::uint32_t>& order) {
  const std::size_t n = order.size();
  std::vector<std::vector<std::uint32_t>> children(n + 1);
  for (std::size_t j = 0; j < n; ++j)
    children[std::min<std::size_t>(e.parent[j], n)].push_back(
        static_cast<std::uint32_t>(j));  // those of roots last
  for (auto& list : children)
    std::stable_sort(list.begin(), list.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return e.count[a] < e.count[b]; });
  std::vector<std::uint32_t> result;
  std::vector<std::pair<std::size_t, std::size_t>> path{{n, 0}};
  while (!path.empty()) {
    auto& [node, next] = path.back();
    if (next < children[node].size()) {
      const std::uint32_t child = children[node][next++];
      path.emplace_back(child, 0);
      continue;
    }
    if (node != n) result.push_back(order[node]);
    path.pop_back();
  }
  return result;
}

// Nested dissection: halves at the median of the longest direction; the separator is the smaller side of the
// cut.
class Dissection {
 public:
  Dissection(const Graph& adjacency, const std::vector<Vec3>& positions)
      : graph_(adjacency), at_(positions), side_(adjacency.size(), none) {}

  std::vector<std::uint32_t> run() {
    std::vector<std::uint32_t> all(graph_.size());
    std::iota(all.begin(), all.end(), std::uint32_t{0});
    split(std::move(all));
    return std::move(order_);
  }

 private:
  static constexpr std::size_t leaf_ = 40;

  void split(std::vector<std::uint32_t> nodes) {
    if (nodes.size() <= leaf_) {
      eliminate_leaf(nodes);
      return;
    }
    std::vector<std::uint32_t> best[3];
    std::size_t best_size = nodes.size();
    for (int axis = 0; axis < 3; ++axis)
      for (const double share : {0.42, 0.5, 0.58}) try_cut(nodes, axis, share, best, best_size);
    if (best_size == nodes.size()) {
      eliminate_leaf(nodes);
      return;
    }
    split(std::move(best[0]));
    split(std::move(best[1]));
    order_.insert(order_.end(), best[2].begin(), best[2].end());
  }

  // The part is small: minimum degree within it.
  void eliminate_leaf(const std::vector<std::uint32_t>& nodes) {
    Graph inner(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) side_[nodes[i]] = static_cast<std::uint32_t>(i);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (const std::uint32_t j : graph_[nodes[i]])
        if (side_[j] != none) inner[i].push_back(side_[j]);
    for (const std::uint32_t node : nodes) side_[node] = none;
    for (const std::uint32_t i : minimum_degree(inner)) order_.push_back(nodes[i]);
  }

  void try_cut(std::vector<std::uint32_t>& nodes, int axis, double share, std::vector<std::uint32_t>* best,
               std::size_t& best_size) {
    std::sort(nodes.begin(), nodes.end(), [&](std::uint32_t a, std::uint32_t b) {
      const double xa = at_[a][axis], xb = at_[b][axis];
      return xa != xb ? xa < xb : a < b;
    });
    const auto middle = static_cast<std::size_t>(share * static_cast<double>(nodes.size()));
    for (std::size_t i = 0; i < nodes.size(); ++i) side_[nodes[i]] = i < middle ? 0 : 1;
    // Koenig: the smallest set of nodes that covers all edges of the cut, by a maximum matching.
    cover_cut(nodes);
    std::vector<std::uint32_t> parts[3];
    for (const std::uint32_t node : nodes) parts[side_[node]].push_back(node);
    for (const std::uint32_t node : nodes) side_[node] = none;
    if (parts[0].empty() || parts[1].empty() || parts[2].size() >= best_size) return;
    best_size = parts[2].size();
    for (int i = 0; i < 3; ++i) best[i] = std::move(parts[i]);
  }

  bool augment(std::uint32_t node, std::vector<std::uint32_t>& match, std::vector<char>& seen) {
    for (const std::uint32_t other : graph_[node]) {
      if (side_[other] != 1 || seen[other]) continue;
      seen[other] = 1;
      touched_.push_back(other);
      if (match[other] == none || augment(match[other], match, seen)) {
        match[other] = node;
        match[node] = other;
        return true;
      }
    }
    return false;
  }

  void cover_cut(const std::vector<std::uint32_t>& nodes) {
    match_.resize(graph_.size(), none);
    seen_.resize(graph_.size(), 0);
    std::vector<std::uint32_t> left;
    for (const std::uint32_t node : nodes) {
      match_[node] = none;
      if (side_[node] == 0 && std::any_of(graph_[node].begin(), graph_[node].end(),
                                          [&](std::uint32_t j) { return side_[j] == 1; }))
        left.push_back(node);
    }
    const auto forget = [&] {
      for (const std::uint32_t node : touched_) seen_[node] = 0;
      touched_.clear();
    };
    for (const std::uint32_t node : left) {
      augment(node, match_, seen_);
      forget();
    }
    // Nodes reached from unmatched left nodes by alternating paths; the cover is left not reached + right
    // reached.
    std::vector<std::uint32_t> open;
    for (const std::uint32_t node : left)
      if (match_[node] == none) open.push_back(node);
    std::vector<std::uint32_t> reached = open;
    for (const std::uint32_t node : reached) seen_[node] = 1, touched_.push_back(node);
    std::vector<std::uint32_t> cover;
    while (!open.empty()) {
      const std::uint32_t node = open.back();
      open.pop_back();
      for (const std::uint32_t other : graph_[node]) {
        if (side_[other] != 1 || seen_[other]) continue;
        seen_[other] = 1;
        touched_.push_back(other);
        cover.push_back(other);
        const std::uint32_t next = match_[other];
        if (next != none && !seen_[next]) {
          seen_[next] = 1;
          touched_.push_back(next);
          open.push_back(next);
        }
      }
    }
    for (const std::uint32_t node : left)
      if (!seen_[node]) cover.push_back(node);
    forget();
    for (const std::uint32_t node : cover) side_[node] = 2;
  }

  const Graph& graph_;
  const std::vector<Vec3>& at_;
  std::vector<std::uint32_t> side_, order_, match_, touched_;
  std::vector<char> seen_;
};

}  // namespace

std::vector<std::uint32_t> elimination_order(const Graph& adjacency, const std::vector<Vec3>& positions) {
  const std::vector<std::uint32_t> by_degree = minimum_degree(adjacency);
  const std::vector<std::uint32_t> dissected = Dissection(adjacency, positions).run();
  const Elimination degree = eliminate(adjacency, by_degree), dissection = eliminate(adjacency, dissected);
  return degree.flops <= dissection.flops ? postorder(degree, by_degree) : postorder(dissection, dissected);
}

}  // namespace forefeel
