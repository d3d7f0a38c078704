#include "geometry/coverage/region_tree.hpp"

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
  RegionNode& here = pool_.nodes[index];
  if (here.kind != RegionNode::Kind::leaf || here.label == Label::safe) return;
  here.kind = RegionNode::Kind::unresolved;
  if (progress_.complete) progress_.marked.push_back(index);
}

bool RegionTree::breaks(const RegionNode& leaf, const Vec3& at) const {
  const Vec3 d = at - centre(leaf);
  const double length = d.norm(), e = reach(leaf) + 1e-6 * grid_.side;
  if (leaf.label == Label::safe) return false;
  if (leaf.label != Label::sparse && length <= thresholds_.widest.sparse_distance + e) return true;
  if (leaf.label == Label::gap) return false;
  const bool sparse = leaf.label == Label::sparse;
  if (length > (sparse ? thresholds_.widest.safe_radius : thresholds_.widest.gap_radius) + e) return false;
  const Vec3 axis(leaf.axis[0], leaf.axis[1], leaf.axis[2]);
  if (axis.isZero()) return false;  // enclosed: its watch reports the change
  const double cosine = sparse ? thresholds_.widest.safe_cos : thresholds_.widest.gap_cos;
  // 1e-6 covers the rounding of the axis to float. A NaN axis means that only a common plane of the states
  // proved the label: then every state in reach breaks it.
  return !(axis.dot(d) + (1 + std::abs(cosine)) * e < (cosine - 1e-6) * length);
}

// Whether a state at `at` may change a label at or below the node.
bool RegionTree::reaches(const RegionNode& node, const Vec3& at) const {
  if (!may_move(node)) return false;
  const bool blank = node.kind == RegionNode::Kind::leaf ? node.label == Label::blank
                                                         : node.below & RegionNode::bit(Label::blank);
  const double radius = blank ? std::max(thresholds_.widest.gap_radius, thresholds_.widest.sparse_distance)
                              : std::max(thresholds_.widest.safe_radius, thresholds_.widest.sparse_distance);
  const double half = 0.5 * node.width() * grid_.side;
  const Vec3 middle = grid_.low_of(node.low) + Vec3::Constant(half);
  const Vec3 beyond = ((at - middle).cwiseAbs().array() - half).max(0.0);
  const double reached = radius * (1 + 1e-6) + grid_.side;
  return beyond.squaredNorm() <= reached * reached;
}

void RegionTree::pass_to(std::int32_t index, const Vec3& at) {
  RegionNode& here = pool_.nodes[index];
  if (!reaches(here, at)) return;
  if (here.kind == RegionNode::Kind::leaf) {
    if (!breaks(here, at)) return;
    mark(index);
    for (std::int32_t up = here.parent; up >= 0 && node(up).below != RegionNode::anything;
         up = node(up).parent)
      pool_.nodes[up].below = RegionNode::anything;
    return;
  }
  std::int32_t link;
  if (waiting_.free.empty()) {
    link = waiting_.all.count();
    waiting_.all.emplace_back();
  } else {
    link = waiting_.free.back();
    waiting_.free.pop_back();
  }
  waiting_.all[link] = {at, here.waiting};
  here.waiting = link;
  here.waits = true;
}

void RegionTree::pass_on(std::int32_t index) {
  for (std::int32_t link = node(index).waiting; link >= 0;) {
    const Insertion here = waiting_.all[link];
    waiting_.free.push_back(link);
    for (std::int32_t child = 0; child < 8; ++child) pass_to(node(index).children + child, here.at);
    link = here.next;
  }
  pool_.nodes[index].waiting = -1;
}

void RegionTree::pass_on_all(std::int32_t index) {
  RegionNode& here = pool_.nodes[index];
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
      pool_.nodes[up].below = RegionNode::anything;
  };
  // A watch may outlive its voxel. The node that replaced it is then marked without need, which only costs time.
  for (const std::uint32_t token : disturbed) wake(static_cast<std::int32_t>(token));
  for (const std::int32_t index : watches_.restless) wake(index);
  watches_.restless.clear();

  const double far = std::max(thresholds_.widest.gap_radius, thresholds_.widest.sparse_distance) + grid_.side;
  const double side = grid_.side * static_cast<double>(1 << roots_.level);
  Voxel first{}, last{};
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double where = at[axis] - grid_.origin[axis];
    const double top = static_cast<double>(roots_.count[axis] - 1);
    if ((where + far) / side < 0 || (where - far) / side > top + 1) return;
    first[axis] = static_cast<std::int32_t>(std::clamp(std::floor((where - far) / side), 0.0, top));
    last[axis] = static_cast<std::int32_t>(std::clamp(std::floor((where + far) / side), 0.0, top));
  }
  for (std::int32_t k = first[2]; k <= last[2]; ++k)
    for (std::int32_t j = first[1]; j <= last[1]; ++j)
      for (std::int32_t i = first[0]; i <= last[0]; ++i) {
        const std::int32_t root = (k * roots_.count[1] + j) * roots_.count[0] + i;
        const bool waited = node(root).waits;
        pass_to(root, at);
        if (node(root).waits && !waited) waiting_.roots.push_back(root);
      }
  if (waiting_.all.size() - waiting_.free.size() > most_waiting) {
    for (const std::int32_t root : waiting_.roots) pass_on_all(root);
    waiting_.roots.clear();
  }
}

}  // namespace forefeel
