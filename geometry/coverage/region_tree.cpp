#include "geometry/coverage/region_tree.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/index/adaptive_lattice.hpp"

namespace forefeel {
namespace {

std::int32_t child_of(const RegionNode& node, const Voxel& voxel) {
  const int shift = node.level - 1;
  return node.children +
         (((voxel[0] >> shift) & 1) | ((voxel[1] >> shift) & 1) << 1 | ((voxel[2] >> shift) & 1) << 2);
}

}  // namespace

RegionTree::SpacingLimits::SpacingLimits(const StateSpaceOptions& options)
    : spacing(options.spacing),
      lattice(options.lattice),
      usual(options.coverage, options.spacing, options.merge_distance * options.spacing),
      widest(lattice ? usual.scaled(lattice->coarsest() / options.spacing) : usual),
      scaled(usual) {}

RegionTree::RegionTree(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options)
    : delaunay_(delaunay),
      query_(points, delaunay),
      thresholds_(options),
      grid_(options.box, options.spacing / 4),
      roots_(grid_),
      far_(points) {
  pool_.nodes.resize(static_cast<std::size_t>(roots_.size()));
  for (std::int32_t root = 0; root < roots_.size(); ++root) {
    pool_.nodes[root].level = static_cast<std::uint8_t>(roots_.level);
    pool_.nodes[root].low = roots_.low(root);
  }
}

Box RegionTree::box_of(const RegionNode& node) const {
  return grid_.cube(node.low, node.width());
}

double RegionTree::spacing_at(const Vec3& q) const {
  return thresholds_.lattice ? thresholds_.lattice->spacing_at(q) : thresholds_.spacing;
}

double RegionTree::gap_radius(const Vec3& q) const {
  return thresholds_.usual.gap_radius * (spacing_at(q) / thresholds_.spacing);
}

Label RegionTree::label_of(const Vec3& q, PathWalk& walk) {
  if (!walk.near.valid()) walk.near = {query_.points().nearest(q).id};
  if (!thresholds_.lattice) return query_.label(q, walk, thresholds_.usual);
  return query_.label(q, walk, thresholds_.usual.scaled(spacing_at(q) / thresholds_.spacing));
}

const Thresholds* RegionTree::limits_over(const RegionNode& node) {
  if (!thresholds_.lattice) return &thresholds_.usual;
  const Vec3 q = centre(node), half = Vec3::Constant(0.5 * (node.width() - 1) * grid_.side);
  const std::optional<double> h = thresholds_.lattice->spacing_over({q - half, q + half});
  if (!h) return nullptr;
  thresholds_.scaled = thresholds_.usual.scaled(*h / thresholds_.spacing);
  return &thresholds_.scaled;
}

Label RegionTree::label_at(const Vec3& q) {
  if (!grid_.box.contains(q)) return label_of(q, walk_);
  const Voxel voxel = grid_.voxel_of(q);
  std::int32_t index = roots_.root_of(voxel);
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
  if (pool_.free.empty()) {
    children = pool_.nodes.count();
    pool_.nodes.resize(pool_.nodes.size() + 8);
  } else {
    children = pool_.free.back();
    pool_.free.pop_back();
  }
  RegionNode& parent = pool_.nodes[index];
  parent.children = children;
  parent.kind = RegionNode::Kind::branch;
  const std::int32_t half = parent.width() / 2;
  for (std::int32_t child = 0; child < 8; ++child) {
    RegionNode& made = pool_.nodes[children + child];
    made = RegionNode{};
    made.parent = index;
    made.level = static_cast<std::uint8_t>(parent.level - 1);
    made.label = parent.label;
    made.low = {parent.low[0] + ((child & 1) ? half : 0), parent.low[1] + ((child & 2) ? half : 0),
                parent.low[2] + ((child & 4) ? half : 0)};
    if (outside(made)) made.kind = RegionNode::Kind::outside;
  }
  // All bits are set, here and above, until a visit finds out which hold.
  for (std::int32_t up = index; up >= 0; up = node(up).parent) pool_.nodes[up].below = RegionNode::anything;
}

// Replaces eight leaves that are all safe, or all gap, by their parent. Repeats this upwards as far as possible.
void RegionTree::collapse(std::int32_t index) {
  for (; index >= 0; index = node(index).parent) {
    RegionNode& parent = pool_.nodes[index];
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
      pool_.nodes[parent.children + child].kind = RegionNode::Kind::outside;
    pool_.free.push_back(parent.children);
    parent.children = -1;
    become_leaf(parent, label);
  }
}

void RegionTree::settle_below(std::int32_t index) {
  if (node(index).kind == RegionNode::Kind::unresolved) resolve(index);
  if (node(index).kind != RegionNode::Kind::branch || !(node(index).below & RegionNode::unresolved_bit))
    return;
  std::uint8_t below = 0;
  for (std::int32_t child = 0; child < 8; ++child) {
    settle_below(node(index).children + child);
    if (node(index).kind != RegionNode::Kind::branch) return;  // collapsing the child reached this node
    below |= summary(node(node(index).children + child));
  }
  pool_.nodes[index].below = below;
  collapse(index);
}

// After the labels below a node changed: computes the summaries of its ancestors anew.
void RegionTree::refresh_above(std::int32_t index) {
  for (std::int32_t up = node(index).parent; up >= 0; up = node(up).parent) {
    RegionNode& above = pool_.nodes[up];
    if (above.kind != RegionNode::Kind::branch) continue;
    std::uint8_t below = 0;
    for (std::int32_t child = 0; child < 8; ++child) below |= summary(node(above.children + child));
    above.below = below;
  }
}

void RegionTree::settle_marked() {
  while (!progress_.marked.empty()) {
    const std::int32_t index = progress_.marked.back();
    const std::int32_t parent = node(index).parent;
    settle_below(index);
    progress_.marked.pop_back();
    collapse(parent);
    // Siblings are adjacent in the list: one refresh after the last of them is enough.
    if (progress_.marked.empty() || node(progress_.marked.back()).parent != parent) refresh_above(index);
  }
}

void RegionTree::settle(const std::function<void(double)>& progress) {
  for (const std::int32_t root : waiting_.roots) pass_on_all(root);
  waiting_.roots.clear();
  if (progress_.complete) return settle_marked();
  if (is_fresh()) settle_fresh(progress);
  for (std::int32_t root = 0; root < roots_.size(); ++root) {
    settle_below(root);
    if (progress && root % 64 == 0) progress(double(root) / double(roots_.size()));
  }
  progress_.complete = true;
  progress_.marked.clear();
}

}  // namespace forefeel
