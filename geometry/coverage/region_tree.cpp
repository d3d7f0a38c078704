#include "geometry/coverage/region_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/coverage/bridge.hpp"
#include "geometry/index/adaptive_lattice.hpp"

namespace forefeel {
namespace {

constexpr std::uint8_t unresolved_bit = 0x10, axis_bit = 0x20, anything = 0x3f;
constexpr int block_level = 2;  // 4 voxels = h wide
constexpr std::uint32_t nobody = 0xffffffffu;
constexpr std::size_t most_waiting = 100'000;  // places that wait for somebody to look: 3 MB

std::uint8_t bit(Label label) {
  return static_cast<std::uint8_t>(1u << static_cast<unsigned>(label));
}

std::int32_t child_of(const RegionNode& node, const std::array<std::int32_t, 3>& voxel) {
  const int shift = node.level - 1;
  return node.children +
         (((voxel[0] >> shift) & 1) | ((voxel[1] >> shift) & 1) << 1 | ((voxel[2] >> shift) & 1) << 2);
}

// Whether an insertion may change a label below without the Delaunay cells telling: safe stays, and sparse voxels that
// a cell speaks for are reported by it.
bool may_move(const RegionNode& node) {
  if (node.kind == RegionNode::Kind::leaf) return node.label != Label::safe;
  return node.kind == RegionNode::Kind::branch &&
         (node.below & (bit(Label::gap) | bit(Label::blank) | axis_bit));
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
      root_level_(block_level + 3) {
  for (std::size_t axis = 0; axis < 3; ++axis) voxels_[axis] = static_cast<std::int32_t>(grid_.count[axis]);
  for (;; ++root_level_) {
    roots_ = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      root_grid_[axis] = ((voxels_[axis] - 1) >> root_level_) + 1;
      roots_ *= static_cast<std::size_t>(root_grid_[axis]);
    }
    if (roots_ <= (1u << 21)) break;
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

Vec3 RegionTree::centre(const RegionNode& node) const {
  if (node.level == 0) return grid_.centre(node.low);
  return grid_.low_of(node.low) + Vec3::Constant(0.5 * voxel_ * node.width());
}

double RegionTree::reach(const RegionNode& node) const {
  const double whole = 0.5 * (node.width() - 1) * voxel_ * std::numbers::sqrt3;
  if (node.level == 0) return whole;
  // Where the box cuts a voxel off, its place is up to half a voxel from the middle of the voxel on each axis.
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (node.low[axis] == 0 || node.low[axis] + node.width() >= voxels_[axis])
      return whole + 0.5 * voxel_ * std::numbers::sqrt3;
  return whole;
}

bool RegionTree::outside(const RegionNode& node) const {
  return node.low[0] >= voxels_[0] || node.low[1] >= voxels_[1] || node.low[2] >= voxels_[2];
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

void RegionTree::become_leaf(RegionNode& node, Label label, const Vec3& axis) {
  node.kind = RegionNode::Kind::leaf;
  node.label = label;
  for (std::size_t i = 0; i < 3; ++i) node.axis[i] = static_cast<float>(axis[static_cast<Eigen::Index>(i)]);
}

std::uint8_t RegionTree::summary(const RegionNode& node) const {
  switch (node.kind) {
    case RegionNode::Kind::unresolved:
      return anything;  // it may become any leaf with nobody telling those above
    case RegionNode::Kind::leaf: {
      const bool by_axis =
          node.label == Label::sparse && !(node.axis[0] == 0 && node.axis[1] == 0 && node.axis[2] == 0);
      return static_cast<std::uint8_t>(bit(node.label) | (by_axis ? axis_bit : 0));
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
  // Conservative until a visit knows better; so are the ancestors, whose bits already hold everything new.
  for (std::int32_t up = index; up >= 0; up = node(up).parent)
    nodes_[static_cast<std::size_t>(up)].below = anything;
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
    for (std::int32_t child = 0; child < 8; ++child)  // a late watch must not wake what is gone
      nodes_[static_cast<std::size_t>(parent.children + child)].kind = RegionNode::Kind::outside;
    free_.push_back(parent.children);
    parent.children = -1;
    become_leaf(parent, label);
  }
}

// Unit directions from q to the states within the radius.
void RegionTree::gather(const Vec3& q, double radius) {
  directions_.clear();
  query_.points().for_each_within(q, radius, [&](std::uint32_t, const Vec3& offset, double squared) {
    directions_.push(offset / std::sqrt(squared));
  });
}

// Turns `axis` until, seen from every point within e of q, each state within the radius is farther from it than
// arccos(cosine); false where a few turns do not do. Why the margin: a . (d - s) <= a . d + e and
// c |d - s| >= c |d| - |c| e for |s| <= e.
bool RegionTree::find_axis(const Vec3& q, double radius, double cosine, double e, Vec3& axis) const {
  const double margin = (1 + std::abs(cosine)) * e;
  constexpr double slack = 2e-9, spare = 0.01;
  for (int turn = 0; turn < 6; ++turn) {
    Vec3 d;
    if (!query_.points().find_in_cone(q, axis, cosine - slack, margin, radius + e, d)) return true;
    const double length = d.norm();
    if (!(length > 0)) return false;
    const Vec3 u = d / length;
    const double wanted = cosine - margin / length - spare;
    const Vec3 aside = axis - axis.dot(u) * u;
    const double width = aside.norm();
    if (wanted <= -1 || width < 1e-6) return false;
    axis = wanted * u + std::sqrt(1 - wanted * wanted) / width * aside;
    axis.normalize();
  }
  return false;
}

// All voxels farther than kappa_p h from every state: gap or blank, if one of the two can be proven for all.
bool RegionTree::prove_far(RegionNode& node, const Thresholds& limits, const Vec3& q, double e,
                           const Vec3& nearest) {
  if (node.label == Label::gap) {
    become_leaf(node, Label::gap);
    return true;
  }
  Vec3 axis(node.axis[0], node.axis[1], node.axis[2]);
  if (!(std::abs(axis.squaredNorm() - 1) < 0.1)) axis = -nearest;
  axis.normalize();
  if (find_axis(q, limits.gap_radius, limits.gap_cos, e, axis)) {
    become_leaf(node, Label::blank, axis);
    return true;
  }
  // Moving by e turns no direction by more than asin(e / nearest): a stricter angle at q suffices for all.
  gather(q, limits.gap_radius - e);
  const double turn = std::asin(std::min(1.0, e / nearest.norm())) + 1e-9;
  const double angle = std::acos(std::clamp(limits.gap_cos, -1.0, 1.0));
  if (angle > turn && solver_.at_most(directions_, std::cos(angle - turn), &axis)) {
    become_leaf(node, Label::gap);
    return true;
  }
  if (!axis.allFinite() || !find_axis(q, limits.gap_radius, limits.gap_cos, e, axis)) return false;
  become_leaf(node, Label::blank, axis);
  return true;
}

// All voxels within kappa_p h of a state, none of them enclosed.
bool RegionTree::prove_sparse(RegionNode& node, const Thresholds& limits, const Vec3& q, double e,
                              const Vec3& nearest) {
  // The corners of a cell around q within reach enclose q: no cone is empty.
  const Spread spread = delaunay_.spread(q, walk_);
  const auto within = [&](const Vec3& corner) {
    return (corner - q).squaredNorm() <= limits.safe_radius * limits.safe_radius;
  };
  if (spread.inside && std::ranges::all_of(spread.at, within)) return false;
  Vec3 axis(node.axis[0], node.axis[1], node.axis[2]);
  if (!(std::abs(axis.squaredNorm() - 1) < 0.1)) axis = -nearest;
  if (!(axis.norm() > 0)) axis = Vec3::UnitX();
  axis.normalize();
  if (!find_axis(q, limits.safe_radius, limits.safe_cos, e, axis)) return false;
  become_leaf(node, Label::sparse, axis);
  return true;
}

bool RegionTree::all_safe(const RegionNode& node, const Thresholds& limits) {
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
          const Vec3 q = grid_.centre(at);
          const Spread spread = delaunay_.spread(q, walk_);
          if (spread.spread > limits.safe_spread || !query_.safe_cone(q, spread, limits)) return false;
        }
  }
  return true;
}

void RegionTree::resolve_voxel(std::int32_t index) {
  RegionNode& here = nodes_[static_cast<std::size_t>(index)];
  const Thresholds& limits = *limits_over(here);
  const Vec3 q = centre(here);
  const bool was_sparse = here.label == Label::sparse;  // a state within kappa_p h is there already
  if (!walk_.near.valid()) {
    walk_.near = {query_.points().nearest(q).id};
    if (!walk_.near.valid()) return become_leaf(here, Label::blank, Vec3::UnitX());
  }
  const Spread spread = delaunay_.spread(q, walk_);
  Vec3 axis = Vec3::Zero();
  const bool coarse = spread.inside && spread.spread > limits.safe_spread;
  const bool enclosed = coarse || query_.safe_cone(q, spread, limits, &axis);
  if (enclosed && spread.spread <= limits.safe_spread) return become_leaf(here, Label::safe);
  if (was_sparse || query_.points().nearest(q, limits.sparse_distance).id != nobody) {
    if (coarse)
      delaunay_.watch(walk_, static_cast<std::uint32_t>(index));
    else if (enclosed && !delaunay_.watch(q, walk_.near, static_cast<std::uint32_t>(index)))
      restless_.push_back(index);
    return become_leaf(here, Label::sparse, enclosed ? Vec3(Vec3::Zero()) : axis);
  }
  if (here.label == Label::gap) return become_leaf(here, Label::gap);
  // Where a state broke an empty cone, another is often close to it.
  axis = Vec3(here.axis[0], here.axis[1], here.axis[2]);
  if (std::abs(axis.squaredNorm() - 1) < 0.1) {
    axis.normalize();
    if (find_axis(q, limits.gap_radius, limits.gap_cos, 0, axis))
      return become_leaf(here, Label::blank, axis);
  }
  if (query_.enclosed(q, limits.gap_radius, limits.gap_cos, limits.merge, &axis))
    return become_leaf(here, Label::gap);
  become_leaf(here, Label::blank, axis);
}

void RegionTree::resolve(std::int32_t index) {
  RegionNode& here = nodes_[static_cast<std::size_t>(index)];
  if (here.level == 0) return resolve_voxel(index);
  const Thresholds* limits = limits_over(here);
  if (!limits) return branch(index);
  const Vec3 q = centre(here);
  const double e = reach(here) * (1 + 1e-9), tiny = 1e-9 * voxel_;
  const PointOctree::Neighbour found = query_.points().nearest(q);
  if (found.id == nobody) return become_leaf(here, Label::blank, Vec3::UnitX());
  const Vec3 offset = delaunay_.position({found.id}) - q;
  const double nearest = std::sqrt(found.squared);
  if (nearest > limits->sparse_distance + e + tiny) {
    if (prove_far(here, *limits, q, e, offset)) return;
  } else if (here.level <= block_level) {
    walk_.near = {found.id};
    if (nearest + e + tiny <= limits->sparse_distance && prove_sparse(here, *limits, q, e, offset)) return;
    if (nearest <= limits->safe_spread + e && all_safe(here, *limits)) return become_leaf(here, Label::safe);
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
    if (node(index).kind != RegionNode::Kind::branch) return;  // the child's collapse went on up to here
    below |= summary(node(node(index).children + child));
  }
  nodes_[static_cast<std::size_t>(index)].below = below;
  collapse(index);
}

// The labels below a node changed: its ancestors' summaries follow, as far as they differ.
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
    if (budget == 0 && (summary(node(index)) & unresolved_bit)) break;
    marked_.pop_back();
    collapse(parent);
    // Brothers stand next to each other in the list: the last of them speaks for all.
    if (marked_.empty() || node(marked_.back()).parent != parent) refresh_above(index);
  }
  pending_ = marked_.size();
  return marked_.empty();
}

bool RegionTree::settle(std::size_t budget, const std::function<void(double)>& progress) {
  for (const std::int32_t root : waiting_roots_) pass_on_all(root);
  waiting_roots_.clear();
  if (complete_) return settle_marked(budget);
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

void RegionTree::mark(std::int32_t index) {
  RegionNode& here = nodes_[static_cast<std::size_t>(index)];
  if (here.kind != RegionNode::Kind::leaf || here.label == Label::safe) return;
  here.kind = RegionNode::Kind::unresolved;
  if (complete_) marked_.push_back(index);
  ++pending_;
}

bool RegionTree::breaks(const RegionNode& leaf, const Vec3& at) const {
  const Vec3 d = at - centre(leaf);
  const double length = d.norm(), e = reach(leaf) + 1e-6 * voxel_;
  if (leaf.label == Label::safe) return false;
  if (leaf.label != Label::sparse && length <= widest_.sparse_distance + e) return true;
  if (leaf.label == Label::gap) return false;
  const bool sparse = leaf.label == Label::sparse;
  if (length > (sparse ? widest_.safe_radius : widest_.gap_radius) + e) return false;
  const Vec3 axis(leaf.axis[0], leaf.axis[1], leaf.axis[2]);
  if (axis.isZero()) return false;  // enclosed: its watch tells
  const double cosine = sparse ? widest_.safe_cos : widest_.gap_cos;
  // 1e-6 covers the axis having been rounded to float.
  // A NaN axis (only coplanarity spoke against the label) breaks with any state in reach.
  return !(axis.dot(d) + (1 + std::abs(cosine)) * e < (cosine - 1e-6) * length);
}

// Whether a state at `at` may change a label below.
bool RegionTree::reaches(const RegionNode& node, const Vec3& at) const {
  if (!may_move(node)) return false;
  const bool blank =
      node.kind == RegionNode::Kind::leaf ? node.label == Label::blank : node.below & bit(Label::blank);
  const double radius = blank ? std::max(widest_.gap_radius, widest_.sparse_distance)
                              : std::max(widest_.safe_radius, widest_.sparse_distance);
  const double half = 0.5 * node.width() * voxel_;
  const Vec3 middle = grid_.low_of(node.low) + Vec3::Constant(half);
  const Vec3 beyond = ((at - middle).cwiseAbs().array() - half).max(0.0);
  const double reached = radius * (1 + 1e-6) + voxel_;
  return beyond.squaredNorm() <= reached * reached;
}

void RegionTree::hand(std::int32_t index, const Vec3& at) {
  RegionNode& here = nodes_[static_cast<std::size_t>(index)];
  if (!reaches(here, at)) return;
  if (here.kind == RegionNode::Kind::leaf) {
    if (!breaks(here, at)) return;
    mark(index);
    for (std::int32_t up = here.parent; up >= 0 && node(up).below != anything; up = node(up).parent)
      nodes_[static_cast<std::size_t>(up)].below = anything;
    return;
  }
  std::int32_t link;
  if (free_waiting_.empty()) {
    link = static_cast<std::int32_t>(waiting_.size());
    waiting_.emplace_back();
  } else {
    link = free_waiting_.back();
    free_waiting_.pop_back();
  }
  waiting_[static_cast<std::size_t>(link)] = {at, here.waiting};
  here.waiting = link;
  here.waits = true;
}

void RegionTree::pass_on(std::int32_t index) {
  for (std::int32_t link = node(index).waiting; link >= 0;) {
    const Waiting here = waiting_[static_cast<std::size_t>(link)];
    free_waiting_.push_back(link);
    for (std::int32_t child = 0; child < 8; ++child) hand(node(index).children + child, here.at);
    link = here.next;
  }
  nodes_[static_cast<std::size_t>(index)].waiting = -1;
}

void RegionTree::pass_on_all(std::int32_t index) {
  RegionNode& here = nodes_[static_cast<std::size_t>(index)];
  const bool waited = here.waits;
  here.waits = false;
  if (here.kind != RegionNode::Kind::branch || !waited) return;
  pass_on(index);
  for (std::int32_t child = 0; child < 8; ++child) pass_on_all(here.children + child);
}

void RegionTree::inserted(const Vec3& at, std::span<const std::uint32_t> disturbed) {
  const auto wake = [&](std::int32_t index) {
    mark(index);
    for (std::int32_t up = node(index).parent; up >= 0; up = node(up).parent)
      nodes_[static_cast<std::size_t>(up)].below = anything;
  };
  // A watch may outlive its voxel; waking whatever took its place costs time, never correctness.
  for (const std::uint32_t token : disturbed) wake(static_cast<std::int32_t>(token));
  for (const std::int32_t index : restless_) wake(index);
  restless_.clear();

  const double far = std::max(widest_.gap_radius, widest_.sparse_distance) + voxel_;
  const double side = voxel_ * static_cast<double>(1 << root_level_);
  std::array<std::int32_t, 3> first{}, last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double where = at[static_cast<Eigen::Index>(axis)] - grid_.origin[static_cast<Eigen::Index>(axis)];
    const double top = static_cast<double>(root_grid_[axis] - 1);
    if ((where + far) / side < 0 || (where - far) / side > top + 1) return;
    first[axis] = static_cast<std::int32_t>(std::clamp(std::floor((where - far) / side), 0.0, top));
    last[axis] = static_cast<std::int32_t>(std::clamp(std::floor((where + far) / side), 0.0, top));
  }
  for (std::int32_t k = first[2]; k <= last[2]; ++k)
    for (std::int32_t j = first[1]; j <= last[1]; ++j)
      for (std::int32_t i = first[0]; i <= last[0]; ++i) {
        const std::int32_t root = (k * root_grid_[1] + j) * root_grid_[0] + i;
        const bool waited = node(root).waits;
        hand(root, at);
        if (node(root).waits && !waited) waiting_roots_.push_back(root);
      }
  if (waiting_.size() - free_waiting_.size() > most_waiting) {
    for (const std::int32_t root : waiting_roots_) pass_on_all(root);
    waiting_roots_.clear();
  }
}

}  // namespace forefeel
