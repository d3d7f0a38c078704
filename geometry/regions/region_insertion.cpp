#include "geometry/regions/region_tree.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {
namespace {

constexpr std::size_t most_waiting = 100'000;  // insertions stored at branches: 3 MB

// Whether an insertion may change a label below the node without a report from the Delaunay cells. Safe stays
// safe, and voxels that are sparse because of their cell are reported when the cell is destroyed.
bool may_move(const RegionNode& node) {
  if (node.kind == RegionNode::Kind::leaf) return node.label != Label::safe;
  return node.kind == RegionNode::Kind::branch &&
         (node.below & (RegionNode::bit(Label::gap) | RegionNode::bit(Label::blank) | RegionNode::axis_bit));
}

}  // namespace

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
  if (axis.isZero()) return false;  // enclosed: its watch reports the change
  const double cosine = sparse ? widest_.safe_cos : widest_.gap_cos;
  // 1e-6 covers the rounding of the axis to float. A NaN axis means that only a common plane of the states
  // proved the label: then every state in reach breaks it.
  return !(axis.dot(d) + (1 + std::abs(cosine)) * e < (cosine - 1e-6) * length);
}

// Whether a state at `at` may change a label at or below the node.
bool RegionTree::reaches(const RegionNode& node, const Vec3& at) const {
  if (!may_move(node)) return false;
  const bool blank = node.kind == RegionNode::Kind::leaf ? node.label == Label::blank
                                                         : node.below & RegionNode::bit(Label::blank);
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
    for (std::int32_t up = here.parent; up >= 0 && node(up).below != RegionNode::anything;
         up = node(up).parent)
      nodes_[static_cast<std::size_t>(up)].below = RegionNode::anything;
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
      nodes_[static_cast<std::size_t>(up)].below = RegionNode::anything;
  };
  // A watch may outlive its voxel. The node that replaced it is then marked without need, which only costs time.
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
