#include "geometry/coverage/region_tree.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {

// For a node whose voxels are all farther than kappa_p h from every state: proves gap or blank for all of
// them.
bool RegionTree::prove_far(RegionNode& node, const Thresholds& limits, const Vec3& q, double e,
                           const Vec3& nearest) {
  if (node.label == Label::gap) {
    become_leaf(node, Label::gap);
    return true;
  }
  Vec3 axis(node.axis[0], node.axis[1], node.axis[2]);
  const std::optional<Label> label = far_.label(limits, q, e, nearest, axis);
  if (label) become_leaf(node, *label, *label == Label::blank ? axis : Vec3(Vec3::Zero()));
  return label.has_value();
}

// For a node whose voxels are all within kappa_p h of a state: proves that none of them is enclosed.
bool RegionTree::prove_sparse(RegionNode& node, const Thresholds& limits, const Vec3& q, double e,
                              const Vec3& nearest) {
  // If the corners of the cell around q are all among the states that FarProof::find_axis() looks at, they enclose q:
  // no cone of 90 degrees is empty.
  const Spread spread = delaunay_.spread(q, walk_);
  const double looked_at = limits.safe_radius + e;
  const auto within = [&](const Vec3& corner) { return (corner - q).squaredNorm() <= looked_at * looked_at; };
  if (spread.inside && std::ranges::all_of(spread.at, within)) return false;
  Vec3 axis(node.axis[0], node.axis[1], node.axis[2]);
  if (!(std::abs(axis.squaredNorm() - 1) < 0.1)) axis = -nearest;
  if (!(axis.norm() > 0)) axis = Vec3::UnitX();
  axis.normalize();
  if (!far_.find_axis(q, limits.safe_radius, limits.safe_cos, e, axis)) return false;
  become_leaf(node, Label::sparse, axis);
  return true;
}

bool RegionTree::all_safe(const RegionNode& node, const Thresholds& limits) {
  // The corners are tested first: if some voxel is not safe, usually a corner is not.
  const std::int32_t w = node.width();
  for (int pass = 0; pass < 2; ++pass) {
    for (std::int32_t k = 0; k < w; ++k)
      for (std::int32_t j = 0; j < w; ++j)
        for (std::int32_t i = 0; i < w; ++i) {
          const bool corner = (i == 0 || i == w - 1) && (j == 0 || j == w - 1) && (k == 0 || k == w - 1);
          if (corner != (pass == 0)) continue;
          const Voxel at{node.low[0] + i, node.low[1] + j, node.low[2] + k};
          if (at[0] >= grid_.count[0] || at[1] >= grid_.count[1] || at[2] >= grid_.count[2]) continue;
          const Vec3 q = grid_.centre(at);
          const Spread spread = delaunay_.spread(q, walk_);
          if (spread.spread > limits.safe_spread || !query_.safe_cone(q, spread, limits)) return false;
        }
  }
  return true;
}

void RegionTree::resolve_voxel(std::int32_t index) {
  RegionNode& here = pool_.nodes[index];
  const Thresholds& limits = *limits_over(here);
  const Vec3 q = centre(here);
  const bool was_sparse = here.label == Label::sparse;  // known: a state lies within kappa_p h
  if (!walk_.near.valid()) {
    walk_.near = {query_.points().nearest(q).id};
    if (!walk_.near.valid()) return become_leaf(here, Label::blank, Vec3::UnitX());
  }
  const Spread spread = delaunay_.spread(q, walk_);
  Vec3 axis = Vec3::Zero();
  const bool coarse = spread.inside && spread.spread > limits.safe_spread;
  const bool enclosed = coarse || query_.safe_cone(q, spread, limits, &axis);
  if (enclosed && spread.spread <= limits.safe_spread) return become_leaf(here, Label::safe);
  const auto near = [&](const Vec3& state) {
    return (state - q).squaredNorm() <= limits.sparse_distance * limits.sparse_distance;
  };
  if (was_sparse || (spread.inside && std::ranges::any_of(spread.at, near)) ||
      query_.points().nearest(q, limits.sparse_distance).id != PointOctree::nobody) {
    if (coarse)
      watch_cell(index);
    else if (enclosed && !watch_place(q, index))
      watches_.restless.push_back(index);
    return become_leaf(here, Label::sparse, enclosed ? Vec3(Vec3::Zero()) : axis);
  }
  if (here.label == Label::gap) return become_leaf(here, Label::gap);
  // After a state has filled the empty cone, another empty cone is often close to it.
  axis = Vec3(here.axis[0], here.axis[1], here.axis[2]);
  if (std::abs(axis.squaredNorm() - 1) < 0.1) {
    axis.normalize();
    if (far_.find_axis(q, limits.gap_radius, limits.gap_cos, 0, axis))
      return become_leaf(here, Label::blank, axis);
  }
  if (query_.enclosed(q, limits.gap_radius, limits.gap_cos, limits.merge, &axis))
    return become_leaf(here, Label::gap);
  become_leaf(here, Label::blank, axis);
}

void RegionTree::resolve(std::int32_t index) {
  RegionNode& here = pool_.nodes[index];
  if (here.level == 0) return resolve_voxel(index);
  const Thresholds* limits = limits_over(here);
  if (!limits) return branch(index);
  const Vec3 q = centre(here);
  const double e = reach(here) * (1 + 1e-9), tiny = 1e-9 * grid_.side;
  const PointOctree::Neighbour found = query_.points().nearest(q);
  if (found.id == PointOctree::nobody) return become_leaf(here, Label::blank, Vec3::UnitX());
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

}  // namespace forefeel
