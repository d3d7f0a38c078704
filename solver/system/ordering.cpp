#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

#include "solver/system/ordering.hpp"

namespace forefeel {
namespace {

using Graph = std::vector<std::vector<std::int32_t>>;

std::vector<std::int32_t> minimum_degree(const Graph& adjacency) {
  const auto n = static_cast<int>(adjacency.size());
  if (n == 0) return {};
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

// Columns of the factor below the diagonal and the elimination tree, for nodes eliminated in `order`.
struct Elimination {
  std::vector<std::int32_t> parent;  // by rank, -1: root
  std::vector<std::int64_t> count;   // entries below the diagonal
  double flops = 0;
};

Elimination eliminate(const Graph& adjacency, const std::vector<std::int32_t>& order) {
  const std::size_t n = order.size();
  std::vector<std::int32_t> rank(n);
  for (std::size_t i = 0; i < n; ++i) rank[static_cast<std::size_t>(order[i])] = static_cast<std::int32_t>(i);
  Elimination e{std::vector<std::int32_t>(n, -1), std::vector<std::int64_t>(n, 0), 0};
  std::vector<std::vector<std::int32_t>> column(n), children(n);
  std::vector<std::size_t> mark(n, n);
  for (std::size_t j = 0; j < n; ++j) {
    const auto take = [&](std::int32_t i) {
      if (static_cast<std::size_t>(i) <= j || mark[static_cast<std::size_t>(i)] == j) return;
      mark[static_cast<std::size_t>(i)] = j;
      column[j].push_back(i);
    };
    for (const std::int32_t node : adjacency[static_cast<std::size_t>(order[j])])
      take(rank[static_cast<std::size_t>(node)]);
    for (const std::int32_t child : children[j]) {
      for (const std::int32_t i : column[static_cast<std::size_t>(child)]) take(i);
      std::vector<std::int32_t>().swap(column[static_cast<std::size_t>(child)]);
    }
    e.count[j] = static_cast<std::int64_t>(column[j].size());
    e.flops += 27.0 * static_cast<double>((e.count[j] + 1) * (e.count[j] + 1));
    if (column[j].empty()) continue;
    e.parent[j] = *std::min_element(column[j].begin(), column[j].end());
    children[static_cast<std::size_t>(e.parent[j])].push_back(static_cast<std::int32_t>(j));
  }
  return e;
}

// Children before parents, the one with the longest column last, so that it can share its parent's front.
std::vector<std::int32_t> postorder(const Elimination& e, const std::vector<std::int32_t>& order) {
  const std::size_t n = order.size();
  std::vector<std::vector<std::int32_t>> children(n + 1);
  for (std::size_t j = 0; j < n; ++j)
    children[e.parent[j] < 0 ? n : static_cast<std::size_t>(e.parent[j])].push_back(
        static_cast<std::int32_t>(j));
  for (auto& list : children)
    std::stable_sort(list.begin(), list.end(), [&](std::int32_t a, std::int32_t b) {
      return e.count[static_cast<std::size_t>(a)] < e.count[static_cast<std::size_t>(b)];
    });
  std::vector<std::int32_t> result;
  std::vector<std::pair<std::size_t, std::size_t>> path{{n, 0}};
  while (!path.empty()) {
    auto& [node, next] = path.back();
    if (next < children[node].size()) {
      const auto child = static_cast<std::size_t>(children[node][next++]);
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
      : graph_(adjacency), at_(positions), side_(adjacency.size(), -1) {}

  std::vector<std::int32_t> run() {
    std::vector<std::int32_t> all(graph_.size());
    std::iota(all.begin(), all.end(), 0);
    split(std::move(all));
    return std::move(order_);
  }

 private:
  static constexpr std::size_t leaf_ = 40;

  void split(std::vector<std::int32_t> nodes) {
    if (nodes.size() <= leaf_) {
      eliminate_leaf(nodes);
      return;
    }
    std::vector<std::int32_t> best[3];
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
  void eliminate_leaf(const std::vector<std::int32_t>& nodes) {
    Graph inner(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i)
      side_[static_cast<std::size_t>(nodes[i])] = static_cast<std::int32_t>(i);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (const std::int32_t j : graph_[static_cast<std::size_t>(nodes[i])])
        if (side_[static_cast<std::size_t>(j)] >= 0) inner[i].push_back(side_[static_cast<std::size_t>(j)]);
    for (const std::int32_t node : nodes) side_[static_cast<std::size_t>(node)] = -1;
    for (const std::int32_t i : minimum_degree(inner)) order_.push_back(nodes[static_cast<std::size_t>(i)]);
  }

  void try_cut(std::vector<std::int32_t>& nodes, int axis, double share, std::vector<std::int32_t>* best,
               std::size_t& best_size) {
    std::sort(nodes.begin(), nodes.end(), [&](std::int32_t a, std::int32_t b) {
      const double xa = at_[static_cast<std::size_t>(a)][axis], xb = at_[static_cast<std::size_t>(b)][axis];
      return xa != xb ? xa < xb : a < b;
    });
    const auto middle = static_cast<std::size_t>(share * static_cast<double>(nodes.size()));
    for (std::size_t i = 0; i < nodes.size(); ++i)
      side_[static_cast<std::size_t>(nodes[i])] = i < middle ? 0 : 1;
    // Koenig: the smallest set of nodes that covers all edges of the cut, by a maximum matching.
    cover_cut(nodes);
    std::vector<std::int32_t> parts[3];
    for (const std::int32_t node : nodes) parts[side_[static_cast<std::size_t>(node)]].push_back(node);
    for (const std::int32_t node : nodes) side_[static_cast<std::size_t>(node)] = -1;
    if (parts[0].empty() || parts[1].empty() || parts[2].size() >= best_size) return;
    best_size = parts[2].size();
    for (int i = 0; i < 3; ++i) best[i] = std::move(parts[i]);
  }

  bool augment(std::int32_t node, std::vector<std::int32_t>& match, std::vector<char>& seen) {
    for (const std::int32_t other : graph_[static_cast<std::size_t>(node)]) {
      if (side_[static_cast<std::size_t>(other)] != 1 || seen[static_cast<std::size_t>(other)]) continue;
      seen[static_cast<std::size_t>(other)] = 1;
      touched_.push_back(other);
      if (match[static_cast<std::size_t>(other)] < 0 ||
          augment(match[static_cast<std::size_t>(other)], match, seen)) {
        match[static_cast<std::size_t>(other)] = node;
        match[static_cast<std::size_t>(node)] = other;
        return true;
      }
    }
    return false;
  }

  void cover_cut(const std::vector<std::int32_t>& nodes) {
    match_.resize(graph_.size(), -1);
    seen_.resize(graph_.size(), 0);
    std::vector<std::int32_t> left;
    for (const std::int32_t node : nodes) {
      match_[static_cast<std::size_t>(node)] = -1;
      if (side_[static_cast<std::size_t>(node)] == 0 &&
          std::any_of(graph_[static_cast<std::size_t>(node)].begin(),
                      graph_[static_cast<std::size_t>(node)].end(),
                      [&](std::int32_t j) { return side_[static_cast<std::size_t>(j)] == 1; }))
        left.push_back(node);
    }
    const auto forget = [&] {
      for (const std::int32_t node : touched_) seen_[static_cast<std::size_t>(node)] = 0;
      touched_.clear();
    };
    for (const std::int32_t node : left) {
      augment(node, match_, seen_);
      forget();
    }
    // Nodes reached from unmatched left nodes by alternating paths; the cover is left not reached + right
    // reached.
    std::vector<std::int32_t> open;
    for (const std::int32_t node : left)
      if (match_[static_cast<std::size_t>(node)] < 0) open.push_back(node);
    std::vector<std::int32_t> reached = open;
    for (const std::int32_t node : reached)
      seen_[static_cast<std::size_t>(node)] = 1, touched_.push_back(node);
    std::vector<std::int32_t> cover;
    while (!open.empty()) {
      const std::int32_t node = open.back();
      open.pop_back();
      for (const std::int32_t other : graph_[static_cast<std::size_t>(node)]) {
        if (side_[static_cast<std::size_t>(other)] != 1 || seen_[static_cast<std::size_t>(other)]) continue;
        seen_[static_cast<std::size_t>(other)] = 1;
        touched_.push_back(other);
        cover.push_back(other);
        const std::int32_t next = match_[static_cast<std::size_t>(other)];
        if (next >= 0 && !seen_[static_cast<std::size_t>(next)]) {
          seen_[static_cast<std::size_t>(next)] = 1;
          touched_.push_back(next);
          open.push_back(next);
        }
      }
    }
    for (const std::int32_t node : left)
      if (!seen_[static_cast<std::size_t>(node)]) cover.push_back(node);
    forget();
    for (const std::int32_t node : cover) side_[static_cast<std::size_t>(node)] = 2;
  }

  const Graph& graph_;
  const std::vector<Vec3>& at_;
  std::vector<std::int32_t> side_, order_, match_, touched_;
  std::vector<char> seen_;
};

}  // namespace

std::vector<std::int32_t> elimination_order(const Graph& adjacency, const std::vector<Vec3>& positions) {
  const std::vector<std::int32_t> by_degree = minimum_degree(adjacency);
  const std::vector<std::int32_t> dissected = Dissection(adjacency, positions).run();
  const Elimination degree = eliminate(adjacency, by_degree), dissection = eliminate(adjacency, dissected);
  return degree.flops <= dissection.flops ? postorder(degree, by_degree) : postorder(dissection, dissected);
}

}  // namespace forefeel
