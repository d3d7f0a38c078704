#pragma once
// The octree behind Regions. Its finest cells (voxels, h/4) carry the label of their centre, exactly; a coarser leaf
// exists only where a bound proves that all its voxels agree, or where its eight children do. So the leaves do not
// depend on the order in which states came, and an insertion only has to find the leaves whose proof it breaks:
//
//   safe     never changes again
//   gap      only within kappa_p h of the new state (the label can only rise to sparse or safe)
//   blank    within kappa_p h, or within the gap radius where the state falls into the leaf's empty cone
//   sparse   a voxel of too wide a spread: only where the Delaunay cell around it is destroyed; else within the safe
//            radius where the state falls into the leaf's empty cone
//
// Finding them waits, too: an insertion leaves its place with the root cubes in reach, and whoever looks at a place
// takes it one level down at each node of the path. Leaves found become unresolved and are worked out when someone looks
// at them, one path at a time, or all of them by settle(), which visits nothing else. On an adaptive lattice a leaf is proven only where h(q) is the
// same throughout; what an insertion may break is judged by the coarsest h.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "geometry/coverage/coverage_query.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/coverage/voxel_grid.hpp"

namespace forefeel {

struct RegionNode {
  enum class Kind : std::uint8_t { unresolved, leaf, branch, outside };
  std::int32_t children = -1;  // first of eight
  std::int32_t parent = -1;
  std::array<std::int32_t, 3> low{};  // lowest voxel
  std::uint8_t level = 0;             // 2^level voxels wide
  Kind kind = Kind::unresolved;
  bool waits = false;           // an insertion may wait here or below
  std::int32_t waiting = -1;    // of a branch: insertions not passed on to its children
  Label label = Label::blank;   // while unresolved: the last known, which can only become better
  std::uint8_t below = 0x3f;    // of a branch: bit per label below; 4: something unresolved; 5: a sparse
                                // leaf proven by its axis
  std::array<float, 3> axis{};  // of the empty cone that proves a blank or sparse leaf; 0: none
  std::int32_t width() const { return 1 << level; }
};

class RegionTree {
 public:
  RegionTree(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options);

  Label label_at(const Vec3& q);
  void inserted(const Vec3& at, std::span<const std::uint32_t> disturbed);
  // Works out at most `budget` leaves; true when none is left.
  bool settle(std::size_t budget, const std::function<void(double)>& progress = {});

  // visit(node) for every resolved leaf inside the box.
  template <class Visit>
  void for_each_leaf(Visit&& visit) const {
    for (std::size_t root = 0; root < roots_; ++root) visit_leaves(static_cast<std::int32_t>(root), visit);
  }
  const RegionNode& node(std::int32_t index) const { return nodes_[static_cast<std::size_t>(index)]; }
  std::size_t root_count() const { return roots_; }
  std::int32_t leaf_of(const std::array<std::int32_t, 3>& voxel) const;  // -1 outside the box
  Box box_of(const RegionNode& node) const;                              // clipped to the box of the states
  const Box& box() const { return grid_.box; }
  double voxel() const { return voxel_; }
  const CoverageQuery& query() const { return query_; }
  Label label_of(const Vec3& q, PathWalk& walk);  // by the indexes, not the leaves
  double gap_radius(const Vec3& q) const;         // [m]
  double rim(const Vec3& q) const;                // rim_reach() at q [m]
  // visit(leaf) for every safe leaf within `reach` [m] of `around`; after settle().
  template <class Visit>
  void for_each_safe_near(const Box& around, double reach, Visit&& visit) const {
    for (std::size_t root = 0; root < roots_; ++root)
      visit_safe_near(static_cast<std::int32_t>(root), around, reach * reach, visit);
  }
  double link_deg() const { return link_deg_; }
  // Leaves marked and insertions not yet passed on since the last settle().
  std::size_t pending() const { return pending_ + waiting_.size() - free_waiting_.size(); }

 private:
  template <class Visit>
  void visit_leaves(std::int32_t index, Visit& visit) const {
    const RegionNode& here = node(index);
    if (here.kind == RegionNode::Kind::leaf) visit(index, here);
    if (here.kind == RegionNode::Kind::branch)
      for (int child = 0; child < 8; ++child) visit_leaves(here.children + child, visit);
  }

  template <class Visit>
  void visit_safe_near(std::int32_t index, const Box& around, double squared, Visit& visit) const {
    const RegionNode& here = node(index);
    if (here.kind == RegionNode::Kind::outside || here.kind == RegionNode::Kind::unresolved) return;
    if (here.kind == RegionNode::Kind::branch && !(here.below & 1u << static_cast<unsigned>(Label::safe)))
      return;
    const Box mine = box_of(here);
    if ((around.low - mine.high).cwiseMax(mine.low - around.high).cwiseMax(0.0).squaredNorm() > squared)
      return;
    if (here.kind == RegionNode::Kind::leaf && here.label == Label::safe) visit(index);
    if (here.kind == RegionNode::Kind::branch)
      for (int child = 0; child < 8; ++child) visit_safe_near(here.children + child, around, squared, visit);
  }
  std::int32_t root_of(const std::array<std::int32_t, 3>& voxel) const;
  Vec3 centre(const RegionNode& node) const;
  double reach(const RegionNode& node) const;  // from its centre to its farthest voxel centre
  bool outside(const RegionNode& node) const;
  void resolve(std::int32_t index);  // to a leaf, or to a branch of unresolved children
  void resolve_voxel(std::int32_t index);
  bool prove_far(RegionNode& node, const Thresholds& limits, const Vec3& q, double e, const Vec3& nearest);
  bool prove_sparse(RegionNode& node, const Thresholds& limits, const Vec3& q, double e, const Vec3& nearest);
  bool all_safe(const RegionNode& node, const Thresholds& limits);
  // The thresholds that hold throughout the node; none where h(q) varies.
  const Thresholds* limits_over(const RegionNode& node);
  bool find_axis(const Vec3& q, double radius, double cosine, double e, Vec3& axis) const;
  void gather(const Vec3& q, double radius);
  void become_leaf(RegionNode& node, Label label, const Vec3& axis = Vec3::Zero());
  void branch(std::int32_t index);
  void collapse(std::int32_t index);
  void settle_below(std::int32_t index, std::size_t& budget);
  bool settle_marked(std::size_t budget);
  void refresh_above(std::int32_t index);
  bool reaches(const RegionNode& node, const Vec3& at) const;
  void hand(std::int32_t index,
            const Vec3& at);             // an insertion to a node: leaves answer at once, branches wait
  void pass_on(std::int32_t index);      // what waits at a branch, to its children
  void pass_on_all(std::int32_t index);  // and theirs
  bool breaks(const RegionNode& leaf, const Vec3& at) const;
  void mark(std::int32_t index);
  std::uint8_t summary(const RegionNode& node) const;

  DelaunayIndex& delaunay_;
  CoverageQuery query_;
  std::shared_ptr<const AdaptiveLattice> lattice_;
  Thresholds limits_;  // at the spacing that the regions are made for
  Thresholds widest_;  // at the coarsest spacing of the lattice
  Thresholds scaled_;  // what limits_over() returned
  double spacing_;     // [m]
  double link_deg_;
  VoxelGrid grid_;
  double voxel_;  // h / 4 [m]
  std::array<std::int32_t, 3> voxels_{}, root_grid_{};
  int root_level_;
  std::size_t roots_ = 0;
  std::vector<RegionNode> nodes_;
  std::vector<std::int32_t> free_;      // octets
  std::vector<std::int32_t> restless_;  // voxels that no watch covers
  struct Waiting {
    Vec3 at;
    std::int32_t next;
  };
  std::vector<Waiting> waiting_;  // lists by node
  std::vector<std::int32_t> free_waiting_;
  std::vector<std::int32_t> waiting_roots_;
  PathWalk walk_;
  Directions directions_;
  ConeSolver solver_;
  std::vector<std::int32_t> marked_;  // since all leaves were last worked out
  bool complete_ = false;             // they were, once: what is unresolved lies below marked_
  std::size_t pending_ = 0;
};

}  // namespace forefeel
