#include <algorithm>
#include <exception>

#include "geometry/coverage/region_tree.hpp"

namespace forefeel {
namespace {

// No exception may leave a parallel loop.
template <class Work>
std::exception_ptr caught(Work&& work) {
  try {
    work();
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

}  // namespace

void RegionTree::watch_cell(std::int32_t index) {
  if (watches_.postponed)
    watches_.wished.push_back({walk_.cell, Vec3::Zero(), {}, index});
  else
    delaunay_.watch(walk_, static_cast<std::uint32_t>(index));
}

bool RegionTree::watch_place(const Vec3& q, std::int32_t index) {
  if (!watches_.postponed) return delaunay_.watch(q, walk_.near, static_cast<std::uint32_t>(index));
  watches_.wished.push_back({nullptr, q, walk_.near, index});
  return true;
}

bool RegionTree::is_fresh() const {
  return pool_.nodes.count() == roots_.size() && std::ranges::all_of(pool_.nodes, [](const RegionNode& root) {
           return root.kind == RegionNode::Kind::unresolved && !root.waits;
         });
}

// Node 0 of the part becomes the root; the others are appended in their order.
void RegionTree::take_root(std::int32_t root, RegionTree& part) {
  const std::int32_t base = pool_.nodes.count() - 1;
  const auto here = [&](std::int32_t index) { return index < 0 ? index : index == 0 ? root : base + index; };
  for (std::int32_t i = 0; i < part.pool_.nodes.count(); ++i) {
    RegionNode node = part.pool_.nodes[i];
    node.children = here(node.children);
    node.parent = i == 0 ? -1 : here(node.parent);
    if (i == 0)
      pool_.nodes[root] = node;
    else
      pool_.nodes.push_back(node);
  }
  for (const std::int32_t index : part.pool_.free) pool_.free.push_back(here(index));
  for (const WishedWatch& wish : part.watches_.wished) {
    const auto token = static_cast<std::uint32_t>(here(wish.index));
    if (wish.cell)
      delaunay_.watch(wish.cell, token);
    else if (!delaunay_.watch(wish.q, wish.near, token))
      watches_.restless.push_back(static_cast<std::int32_t>(token));
  }
  part.pool_.free.clear();
  part.watches_.wished.clear();
}

// Called on a part of the tree: settles its only root, which starts as `root`.
std::exception_ptr RegionTree::settle_root(const RegionNode& root) {
  return caught([&] {
    pool_.nodes.assign(1, root);
    walk_ = {};
    settle_below(0);
  });
}

void RegionTree::settle_fresh(const std::function<void(double)>& progress) {
  SignedVector<RegionNode> roots;
  roots.swap(pool_.nodes);
  RegionTree pattern(*this);  // options and grid, without nodes
  pattern.watches_.postponed = true;
  pool_.nodes = roots;
  std::exception_ptr failed;
#pragma omp parallel
  {
    RegionTree part(pattern);
#pragma omp for schedule(dynamic) ordered
    for (std::int32_t root = 0; root < roots_.size(); ++root) {
      std::exception_ptr mine = part.settle_root(roots[root]);
#pragma omp ordered
      {
        if (!failed && !mine)
          mine = caught([&] {
            take_root(root, part);
            if (progress && root % 16 == 0) progress(double(root) / double(roots_.size()));
          });
        if (!failed) failed = mine;
      }
    }
  }
  if (failed) std::rethrow_exception(failed);
}

}  // namespace forefeel
