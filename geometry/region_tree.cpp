#include "geometry/region_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace forefeel {
namespace {

constexpr std::uint8_t unresolved_bit = 0x10;
constexpr int block_level = 2;        // 4 voxels = h wide
constexpr std::uint32_t nobody = 0xffffffffu;

std::uint8_t bit(Label label) { return static_cast<std::uint8_t>(1u << static_cast<unsigned>(label)); }

}  // namespace

RegionTree::RegionTree(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options)
    : delaunay_(delaunay),
      query_(points, delaunay),
      limits_(options.coverage, options.spacing, options.merge_distance * options.spacing),
      box_(options.box),
      voxel_(options.spacing / 4),
      root_level_(block_level + 3) {
  for (int axis = 0; axis < 3; ++axis)
    voxels_[static_cast<std::size_t>(axis)] =
        std::max(1, static_cast<std::int32_t>(std::ceil(box_.size()[axis] / voxel_ - 1e-6)));
  for (;; ++root_level_) {
    roots_ = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      root_grid_[axis] = ((voxels_[axis] - 1) >> root_level_) + 1;
      roots_ *= static_cast<std::size_t>(root_grid_[axis]);
    }
    if (roots_ <= (1u << 21)) break;
  }
  const Vec3 extent(voxels_[0], voxels_[1], voxels_[2]);
  origin_ = box_.centre() - 0.5 * voxel_ * extent;
  nodes_.resize(roots_);
  for (std::size_t root = 0; root < roots_; ++root) {
    const auto r = static_cast<std::int32_t>(root);
    nodes_[root].level = static_cast<std::uint8_t>(root_level_);
    nodes_[root].low = {(r % root_grid_[0]) << root_level_, (r / root_grid_[0] % root_grid_[1]) << root_level_,
                        (r / root_grid_[0] / root_grid_[1]) << root_level_};
  }
  pending_ = roots_;
}

Vec3 RegionTree::centre(const RegionNode& node) const {
  const double half = 0.5 * node.width();
  return origin_ + voxel_ * Vec3(node.low[0] + half, node.low[1] + half, node.low[2] + half);
}

double RegionTree::reach(const RegionNode& node) const {
  return 0.5 * (node.width() - 1) * voxel_ * std::numbers::sqrt3;
}

bool RegionTree::outside(const RegionNode& node) const {
  return node.low[0] >= voxels_[0] || node.low[1] >= voxels_[1] || node.low[2] >= voxels_[2];
}

Box RegionTree::box_of(const RegionNode& node) const {
  const Vec3 low = origin_ + voxel_ * Vec3(node.low[0], node.low[1], node.low[2]);
  return {low.cwiseMax(box_.low).cwiseMin(box_.high),
          (low + Vec3::Constant(voxel_ * node.width())).cwiseMin(box_.high).cwiseMax(box_.low)};
}

std::int32_t RegionTree::leaf_of(const std::array<std::int32_t, 3>& voxel) const {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (voxel[axis] < 0 || voxel[axis] >= voxels_[axis]) return -1;
  std::int32_t index = ((voxel[2] >> root_level_) * root_grid_[1] + (voxel[1] >> root_level_)) * root_grid_[0] +
                       (voxel[0] >> root_level_);
  while (node(index).kind == RegionNode::Kind::branch) {
    const int shift = node(index).level - 1;
    index = node(index).children +
            (((voxel[0] >> shift) & 1) | ((voxel[1] >> shift) & 1) << 1 | ((voxel[2] >> shift) & 1) << 2);
  }
  return index;
}

Label RegionTree::label_at(const Vec3& q) {
  if (!box_.contains(q)) return query_.label(q, {query_.points().nearest(q).id}, limits_);
  std::array<std::int32_t, 3> voxel;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    voxel[axis] =
        std::clamp(static_cast<std::int32_t>(std::floor((q[a] - origin_[a]) / voxel_)), 0, voxels_[axis] - 1);
  }
  std::int32_t index = leaf_of(voxel);
  while (node(index).kind == RegionNode::Kind::unresolved) {
    resolve(index);
    index = leaf_of(voxel);
  }
  const Label label = node(index).label;
  collapse(node(index).parent);
  return label;
}

void RegionTree::become_leaf(RegionNode& node, Label label, const Vec3& axis) {
  node.kind = RegionNode::Kind::leaf;
  node.label = label;
  for (std::size_t i = 0; i < 3; ++i) node.axis[i] = static_cast<float>(axis[static_cast<Eigen::Index>(i)]);
}

std::uint8_t RegionTree::summary(const RegionNode& node) const {
  switch (node.kind) {
    case RegionNode::Kind::unresolved: return unresolved_bit;
    case RegionNode::Kind::leaf: return bit(node.label);
    case RegionNode::Kind::branch: return node.below;
    case RegionNode::Kind::outside: break;
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
    made.low = {parent.low[0] + ((child & 1) ? half : 0), parent.low[1] + ((child & 2) ? half : 0),
                parent.low[2] + ((child & 4) ? half : 0)};
    if (outside(made)) made.kind = RegionNode::Kind::outside;
  }
  // Conservative until a visit knows better; so are the ancestors, whose bits already hold everything new.
  for (std::int32_t up = index; up >= 0; up = node(up).parent) nodes_[static_cast<std::size_t>(up)].below = 0x1f;
}

// Eight leaves that are all safe, or all gap, need no proof of their own: the parent replaces them.
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
    free_.push_back(parent.children);
    parent.children = -1;
    become_leaf(parent, label);
  }
}

void RegionTree::gather(const Vec3& q, double radius) {
  offsets_.clear();
  query_.points().for_each_within(q, radius, [&](std::uint32_t, const Vec3& offset, double squared) {
    offsets_.push_back({offset, std::sqrt(squared)});
  });
}

// Whether, seen from every point within e of the apex, each gathered state is farther from the axis than
// arccos(cosine): a . (d - s) <= a . d + e and c |d - s| >= c |d| - |c| e for |s| <= e.
bool RegionTree::cone_holds(const Vec3& axis, double cosine, double e) const {
  const double margin = (1 + std::abs(cosine)) * e;
  for (const Offset& d : offsets_)
    if (!(axis.dot(d.at) + margin < cosine * d.length - 2e-9 * d.length)) return false;
  return true;
}

// All voxels farther than kappa_p h from every state: gap or blank, if one of the two can be proven for all.
bool RegionTree::prove_far(RegionNode& node, const Vec3& q, double e, double nearest) {
  gather(q, limits_.gap_radius + e);
  Vec3 axis = Vec3::Zero();
  for (const Offset& d : offsets_) axis -= d.at / d.length;
  axis = axis.norm() > 0 ? axis.normalized() : Vec3(Vec3::UnitX());
  if (cone_holds(axis, limits_.gap_cos, e)) {
    become_leaf(node, Label::blank, axis);
    return true;
  }
  // Moving by e turns no direction by more than asin(e / nearest): a stricter angle at q suffices for all.
  directions_.clear();
  for (const Offset& d : offsets_)
    if (d.length <= limits_.gap_radius - e) directions_.push(d.at / d.length);
  const double turn = std::asin(std::min(1.0, e / nearest)) + 1e-9;
  const double angle = std::acos(std::clamp(limits_.gap_cos, -1.0, 1.0));
  if (angle > turn && solver_.at_most(directions_, std::cos(angle - turn), &axis)) {
    become_leaf(node, Label::gap);
    return true;
  }
  directions_.clear();
  for (const Offset& d : offsets_) directions_.push(d.at / d.length);
  if (!solver_.at_most(directions_, limits_.gap_cos, &axis) && cone_holds(axis, limits_.gap_cos, e)) {
    become_leaf(node, Label::blank, axis);
    return true;
  }
  return false;
}

// All voxels within kappa_p h of a state, none of them enclosed.
bool RegionTree::prove_sparse(RegionNode& node, const Vec3& q, double e) {
  gather(q, limits_.safe_radius + e);
  Vec3 axis = Vec3::Zero();
  for (const Offset& d : offsets_) axis -= d.at;
  axis = axis.norm() > 0 ? axis.normalized() : Vec3(Vec3::UnitX());
  if (!cone_holds(axis, limits_.safe_cos, e)) return false;
  become_leaf(node, Label::sparse, axis);
  return true;
}

bool RegionTree::all_safe(const RegionNode& node, StateId near) const {
  // Corners first: where not all is safe, one of them usually is not.
  const std::int32_t w = node.width();
  for (int pass = 0; pass < 2; ++pass) {
    for (std::int32_t k = 0; k < w; ++k)
      for (std::int32_t j = 0; j < w; ++j)
        for (std::int32_t i = 0; i < w; ++i) {
          const bool corner = (i == 0 || i == w - 1) && (j == 0 || j == w - 1) && (k == 0 || k == w - 1);
          if (corner != (pass == 0)) continue;
          const std::array<std::int32_t, 3> at{node.low[0] + i, node.low[1] + j, node.low[2] + k};
          if (at[0] >= voxels_[0] || at[1] >= voxels_[1] || at[2] >= voxels_[2]) continue;
          const Vec3 q = origin_ + voxel_ * Vec3(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5);
          const Spread spread = delaunay_.spread(q, near);
          if (spread.spread > limits_.safe_spread || !query_.safe_cone(q, spread, limits_)) return false;
          near = spread.states[0];
        }
  }
  return true;
}

void RegionTree::resolve_voxel(std::int32_t index) {
  RegionNode& here = nodes_[static_cast<std::size_t>(index)];
  const Vec3 q = centre(here);
  const PointOctree::Neighbour nearest = query_.points().nearest(q);
  if (nearest.id == nobody) return become_leaf(here, Label::blank, Vec3::UnitX());
  const Spread spread = delaunay_.spread(q, {nearest.id});
  Vec3 axis = Vec3::Zero();
  const bool enclosed = query_.safe_cone(q, spread, limits_, &axis);
  if (enclosed && spread.spread <= limits_.safe_spread) return become_leaf(here, Label::safe);
  if (nearest.squared <= limits_.sparse_distance * limits_.sparse_distance) {
    if (enclosed) {
      axis = Vec3::Zero();
      if (!delaunay_.watch(q, {nearest.id}, static_cast<std::uint32_t>(index))) restless_.push_back(index);
    }
    return become_leaf(here, Label::sparse, axis);
  }
  if (query_.enclosed(q, limits_.gap_radius, limits_.gap_cos, limits_.merge, &axis))
    return become_leaf(here, Label::gap);
  become_leaf(here, Label::blank, axis);
}

void RegionTree::resolve(std::int32_t index) {
  RegionNode& here = nodes_[static_cast<std::size_t>(index)];
  if (here.level == 0) return resolve_voxel(index);
  const Vec3 q = centre(here);
  const double e = reach(here) * (1 + 1e-9), tiny = 1e-9 * voxel_;
  const PointOctree::Neighbour found = query_.points().nearest(q);
  if (found.id == nobody) return become_leaf(here, Label::blank, Vec3::UnitX());
  const double nearest = std::sqrt(found.squared);
  if (nearest > limits_.sparse_distance + e + tiny) {
    if (prove_far(here, q, e, nearest)) return;
  } else if (here.level <= block_level) {
    if (nearest + e + tiny <= limits_.sparse_distance && prove_sparse(here, q, e)) return;
    if (nearest <= limits_.safe_spread + e && all_safe(here, {found.id})) return become_leaf(here, Label::safe);
  }
  branch(index);
}

void RegionTree::settle_below(std::int32_t index, std::size_t& budget) {
  if (budget == 0) return;
  if (node(index).kind == RegionNode::Kind::unresolved) {
    --budget;
    resolve(index);
  }
  if (node(index).kind != RegionNode::Kind::branch || !(node(index).below & unresolved_bit)) return;
  std::uint8_t below = 0;
  for (std::int32_t child = 0; child < 8; ++child) {
    settle_below(node(index).children + child, budget);
    if (node(index).kind != RegionNode::Kind::branch) return;   // the child's collapse went on up to here
    below |= summary(node(node(index).children + child));
  }
  nodes_[static_cast<std::size_t>(index)].below = below;
  collapse(index);
}

bool RegionTree::settle(std::size_t budget, const std::function<void(double)>& progress) {
  if (pending_ == 0) return true;
  for (std::size_t root = 0; root < roots_ && budget > 0; ++root) {
    settle_below(static_cast<std::int32_t>(root), budget);
    if (progress && root % 64 == 0) progress(static_cast<double>(root) / static_cast<double>(roots_));
  }
  if (budget == 0) return false;
  pending_ = 0;
  return true;
}

void RegionTree::mark(RegionNode& node) {
  if (node.kind != RegionNode::Kind::leaf || node.label == Label::safe) return;
  node.kind = RegionNode::Kind::unresolved;
  ++pending_;
}

bool RegionTree::breaks(const RegionNode& leaf, const Vec3& at) const {
  const Vec3 d = at - centre(leaf);
  const double length = d.norm(), e = reach(leaf) + 1e-6 * voxel_;
  if (leaf.label == Label::safe) return false;
  if (leaf.label != Label::sparse && length <= limits_.sparse_distance + e) return true;
  if (leaf.label == Label::gap) return false;
  const bool sparse = leaf.label == Label::sparse;
  if (length > (sparse ? limits_.safe_radius : limits_.gap_radius) + e) return false;
  const Vec3 axis(leaf.axis[0], leaf.axis[1], leaf.axis[2]);
  if (axis.isZero()) return false;   // enclosed: its watch tells
  const double cosine = sparse ? limits_.safe_cos : limits_.gap_cos;
  // 1e-6 covers the axis having been rounded to float.
  // A NaN axis (only coplanarity spoke against the label) breaks with any state in reach.
  return !(axis.dot(d) + (1 + std::abs(cosine)) * e < (cosine - 1e-6) * length);
}

std::uint8_t RegionTree::disturb(std::int32_t index, const Vec3& at) {
  RegionNode& here = nodes_[static_cast<std::size_t>(index)];
  if (here.kind == RegionNode::Kind::leaf && breaks(here, at)) mark(here);
  if (here.kind != RegionNode::Kind::branch) return summary(here);
  const std::uint8_t moving = here.below & static_cast<std::uint8_t>(~(bit(Label::safe) | unresolved_bit));
  if (!moving) return here.below;
  const double radius = (moving & bit(Label::blank)) ? std::max(limits_.gap_radius, limits_.sparse_distance)
                                                     : std::max(limits_.safe_radius, limits_.sparse_distance);
  const double half = 0.5 * here.width() * voxel_;
  const Vec3 beyond = ((at - centre(here)).cwiseAbs().array() - half).max(0.0);
  const double reached = radius * (1 + 1e-6) + voxel_;
  if (beyond.squaredNorm() > reached * reached) return here.below;
  std::uint8_t below = 0;
  for (std::int32_t child = 0; child < 8; ++child) below |= disturb(here.children + child, at);
  return here.below = below;
}

void RegionTree::inserted(const Vec3& at, std::span<const std::uint32_t> disturbed) {
  const auto wake = [&](std::int32_t index) {
    RegionNode& leaf = nodes_[static_cast<std::size_t>(index)];
    mark(leaf);
    for (std::int32_t up = leaf.parent; up >= 0; up = node(up).parent)
      nodes_[static_cast<std::size_t>(up)].below |= unresolved_bit;
  };
  // A watch may outlive its voxel; waking whatever took its place costs time, never correctness.
  for (const std::uint32_t token : disturbed) wake(static_cast<std::int32_t>(token));
  for (const std::int32_t index : restless_) wake(index);
  restless_.clear();

  const double far = std::max(limits_.gap_radius, limits_.sparse_distance) + voxel_;
  const double side = voxel_ * static_cast<double>(1 << root_level_);
  std::array<std::int32_t, 3> first{}, last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double where = at[static_cast<Eigen::Index>(axis)] - origin_[static_cast<Eigen::Index>(axis)];
    const double top = static_cast<double>(root_grid_[axis] - 1);
    if ((where + far) / side < 0 || (where - far) / side > top + 1) return;
    first[axis] = static_cast<std::int32_t>(std::clamp(std::floor((where - far) / side), 0.0, top));
    last[axis] = static_cast<std::int32_t>(std::clamp(std::floor((where + far) / side), 0.0, top));
  }
  for (std::int32_t k = first[2]; k <= last[2]; ++k)
    for (std::int32_t j = first[1]; j <= last[1]; ++j)
      for (std::int32_t i = first[0]; i <= last[0]; ++i)
        disturb((k * root_grid_[1] + j) * root_grid_[0] + i, at);
}

}  // namespace forefeel
