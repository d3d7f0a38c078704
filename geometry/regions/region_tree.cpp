#include "geometry/regions/region_tree.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/index/adaptive_lattice.hpp"
#include "geometry/regions/bridge.hpp"

namespace forefeel {
namespace {

constexpr int block_level = 2;  // 4 voxels: h wide
constexpr std::size_t most_roots = 1u << 21;

std::int32_t child_of(const RegionNode& node, const std::array<std::int32_t, 3>& voxel) {
  const int shift = node.level - 1;
  return node.children +
         (((voxel[0] >> shift) & 1) | ((voxel[1] >> shift) & 1) << 1 | ((voxel[2] >> shift) & 1) << 2);
}

}  // namespace

RegionTree::RegionTree(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options)
    : delaunay_(delaunay),
      query_(points, delaunay),
      lattice_(options.lattice),
      limits_(options.coverage, options.spacing, options.merge_distance * options.spacing),
      widest_(lattice_ ? limits_.scaled(lattice_->coarsest() / options.spacing) : limits_),
      scaled_(limits_),
      spacing_(options.spacing),
      link_deg_(bridge_link_deg(options.coverage.sparse_distance)),
      grid_(options.box, options.spacing / 4),
      voxel_(grid_.side),
      root_level_(block_level + 3),
      far_(points) {
  for (std::size_t axis = 0; axis < 3; ++axis) voxels_[axis] = static_cast<std::int32_t>(grid_.count[axis]);
  for (;; ++root_level_) {
    roots_ = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      root_grid_[axis] = ((voxels_[axis] - 1) >> root_level_) + 1;
      roots_ *= static_cast<std::size_t>(root_grid_[axis]);
    }
    if (roots_ <= most_roots) break;
  }
  nodes_.resize(roots_);
  for (std::size_t root = 0; root < roots_; ++root) {
    const auto r = static_cast<std::int32_t>(root);
    nodes_[root].level = static_cast<std::uint8_t>(root_level_);
    nodes_[root].low = {(r % root_grid_[0]) << root_level_,
                        (r / root_grid_[0] % root_grid_[1]) << root_level_,
                        (r / root_grid_[0] / root_grid_[1]) << root_level_};
  }
  pending_ = roots_;
}

Box RegionTree::box_of(const RegionNode& node) const {
  return grid_.cube(node.low, node.width());
}

std::int32_t RegionTree::root_of(const std::array<std::int32_t, 3>& voxel) const {
  return ((voxel[2] >> root_level_) * root_grid_[1] + (voxel[1] >> root_level_)) * root_grid_[0] +
         (voxel[0] >> root_level_);
}

std::int32_t RegionTree::leaf_of(const std::array<std::int32_t, 3>& voxel) const {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (voxel[axis] < 0 || voxel[axis] >= voxels_[axis]) return -1;
  std::int32_t index = root_of(voxel);
  while (node(index).kind == RegionNode::Kind::branch) index = child_of(node(index), voxel);
  return index;
}

Label RegionTree::label_of(const Vec3& q, PathWalk& walk) {
  if (!walk.near.valid()) walk.near = {query_.points().nearest(q).id};
  if (!lattice_) return query_.label(q, walk, limits_);
  return query_.label(q, walk, limits_.scaled(lattice_->spacing_at(q) / spacing_));
}

double RegionTree::gap_radius(const Vec3& q) const {
  return limits_.gap_radius * (lattice_ ? lattice_->spacing_at(q) / spacing_ : 1);
}

double RegionTree::rim(const Vec3& q) const {
  return rim_reach(limits_.sparse_distance / spacing_, lattice_ ? lattice_->spacing_at(q) : spacing_);
}

const Thresholds* RegionTree::limits_over(const RegionNode& node) {
  if (!lattice_) return &limits_;
  const Vec3 q = centre(node), half = Vec3::Constant(0.5 * (node.width() - 1) * voxel_);
  const std::optional<double> h = lattice_->spacing_over({q - half, q + half});
  if (!h) return nullptr;
  scaled_ = limits_.scaled(*h / spacing_);
  return &scaled_;
}

Label RegionTree::label_at(const Vec3& q) {
  if (!grid_.box.contains(q)) return label_of(q, walk_);
  const std::array<std::int32_t, 3> voxel = grid_.voxel_of(q);
  std::int32_t index = root_of(voxel);
  for (;;) {
    if (node(index).waiting >= 0) pass_on(index);
    if (node(index).kind == RegionNode::Kind::unresolved) resolve(index);
    if (node(index).kind != RegionNode::Kind::branch) break;
    index = child_of(node(index), voxel);
  }
  const Label label = node(index).label;
  collapse(node(index).parent);
  return label;
}

std::uint8_t RegionTree::summary(const RegionNode& node) const {
  switch (node.kind) {
    case RegionNode::Kind::unresolved:
      return RegionNode::anything;  // it may become any leaf, and the nodes above are not updated then
    case RegionNode::Kind::leaf: {
      const bool by_axis =
          node.label == Label::sparse && !(node.axis[0] == 0 && node.axis[1] == 0 && node.axis[2] == 0);
      return static_cast<std::uint8_t>(RegionNode::bit(node.label) | (by_axis ? RegionNode::axis_bit : 0));
    }
    case RegionNode::Kind::branch:
      return node.below;
    case RegionNode::Kind::outside:
      break;
  }
  return 0;
}

void RegionTree::branch(std::int32_t index) {
  std::int32_t children;
  if (free_.empty()) {
    children = static_cast<std::int32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 8);
  } else {
    children = free_.back();
    free_.pop_back();
  }
  RegionNode& parent = nodes_[static_cast<std::size_t>(index)];
  parent.children = children;
  parent.kind = RegionNode::Kind::branch;
  const std::int32_t half = parent.width() / 2;
  for (std::int32_t child = 0; child < 8; ++child) {
    RegionNode& made = nodes_[static_cast<std::size_t>(children + child)];
    made = RegionNode{};
    made.parent = index;
    made.level = static_cast<std::uint8_t>(parent.level - 1);
    made.label = parent.label;
    made.low = {parent.low[0] + ((child & 1) ? half : 0), parent.low[1] + ((child & 2) ? half : 0),
                parent.low[2] + ((child & 4) ? half : 0)};
    if (outside(made)) made.kind = RegionNode::Kind::outside;
  }
  // All bits are set, here and above, until a visit finds out which hold.
  for (std::int32_t up = index; up >= 0; up = node(up).parent)
    nodes_[static_cast<std::size_t>(up)].below = RegionNode::anything;
}

// Replaces eight leaves that are all safe, or all gap, by their parent. Repeats this upwards as far as possible.
void RegionTree::collapse(std::int32_t index) {
  for (; index >= 0; index = node(index).parent) {
    RegionNode& parent = nodes_[static_cast<std::size_t>(index)];
    if (parent.kind != RegionNode::Kind::branch) return;
    bool first = true;
    Label label = Label::blank;
    for (std::int32_t child = 0; child < 8; ++child) {
      const RegionNode& below = node(parent.children + child);
      if (below.kind == RegionNode::Kind::outside) continue;
      if (below.kind != RegionNode::Kind::leaf) return;
      if (first) label = below.label;
      if (below.label != label || (label != Label::safe && label != Label::gap)) return;
      first = false;
    }
    for (std::int32_t child = 0; child < 8; ++child)  // a watch that reports later must not mark them
      nodes_[static_cast<std::size_t>(parent.children + child)].kind = RegionNode::Kind::outside;
    free_.push_back(parent.children);
    parent.children = -1;
    become_leaf(parent, label);
  }
}

void RegionTree::settle_below(std::int32_t index, std::size_t& budget) {
  if (budget == 0) return;
  if (node(index).kind == RegionNode::Kind::unresolved) {
    --budget;
    resolve(index);
  }
  if (node(index).kind != RegionNode::Kind::branch || !(node(index).below & RegionNode::unresolved_bit))
    return;
  std::uint8_t below = 0;
  for (std::int32_t child = 0; child < 8; ++child) {
    settle_below(node(index).children + child, budget);
    if (node(index).kind != RegionNode::Kind::branch) return;  // collapsing the child reached this node
    below |= summary(node(node(index).children + child));
  }
  nodes_[static_cast<std::size_t>(index)].below = below;
  collapse(index);
}

// After the labels below a node changed: computes the summaries of its ancestors anew.
void RegionTree::refresh_above(std::int32_t index) {
  for (std::int32_t up = node(index).parent; up >= 0; up = node(up).parent) {
    RegionNode& above = nodes_[static_cast<std::size_t>(up)];
    if (above.kind != RegionNode::Kind::branch) continue;
    std::uint8_t below = 0;
    for (std::int32_t child = 0; child < 8; ++child) below |= summary(node(above.children + child));
    above.below = below;
  }
}

bool RegionTree::settle_marked(std::size_t budget) {
  while (!marked_.empty() && budget > 0) {
    const std::int32_t index = marked_.back();
    const std::int32_t parent = node(index).parent;
    settle_below(index, budget);
    if (budget == 0 && (summary(node(index)) & RegionNode::unresolved_bit)) break;
    marked_.pop_back();
    collapse(parent);
    // Siblings are adjacent in the list: one refresh after the last of them is enough.
    if (marked_.empty() || node(marked_.back()).parent != parent) refresh_above(index);
  }
  pending_ = marked_.size();
  return marked_.empty();
}

bool RegionTree::settle(std::size_t budget, const std::function<void(double)>& progress) {
  for (const std::int32_t root : waiting_roots_) pass_on_all(root);
  waiting_roots_.clear();
  if (complete_) return settle_marked(budget);
  if (budget == static_cast<std::size_t>(-1) && is_fresh()) settle_fresh(progress);
  for (std::size_t root = 0; root < roots_ && budget > 0; ++root) {
    settle_below(static_cast<std::int32_t>(root), budget);
    if (progress && root % 64 == 0) progress(static_cast<double>(root) / static_cast<double>(roots_));
  }
  if (budget == 0) return false;
  complete_ = true;
  marked_.clear();
  pending_ = 0;
  return true;
}

}  // namespace forefeel
