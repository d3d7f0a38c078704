#pragma once
// The octree behind Regions. Its finest cells are voxels of side h/4; each has exactly the label of its centre. A
// larger leaf exists only if a bound proves that all its voxels have one label, or if its eight children have one
// label. So the leaves do not depend on the order in which states were inserted.
//
// An insertion marks the leaves whose proof it may break, and no others:
//   safe     is never marked: it stays safe
//   gap      within kappa_p h of the new state (the label can only rise to sparse or safe)
//   blank    within kappa_p h; or within the gap radius, if the state lies in the leaf's empty cone
//   sparse   a voxel whose spread is too wide: only when the Delaunay cell around it is destroyed.
//            Any other: within the safe radius, if the state lies in the leaf's empty cone
//
// The marking is lazy. An insertion is stored with the root cubes in its reach; label_at() passes it on by one level at
// each node of its path. Marked leaves are unresolved. label_at() resolves those on its path; settle() resolves all of
// them and visits no other leaves. On an adaptive lattice a leaf is proven only where h(q) is constant, and the
// coarsest h decides which leaves an insertion marks.
//
// The first settle() shares the root cubes among threads. Each root is settled in a tree of its own, and
// these are joined in the order of the roots. So nodes and labels are the same for any number of threads.
//
// region_tree.cpp: structure and settling. region_threads.cpp: the first settling. region_proofs.cpp: the
// labels of voxels and the bounds for larger leaves. region_insertion.cpp: what an insertion marks.
// Lengths in [m].

#include <array>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "geometry/common/signed_vector.hpp"
#include "geometry/coverage/coverage_query.hpp"
#include "geometry/coverage/far_proof.hpp"
#include "geometry/coverage/state_space_options.hpp"
#include "geometry/coverage/voxel_grid.hpp"

namespace forefeel {

inline constexpr int block_level = 2;  // largest leaves that are proven sparse or safe: 4 voxels, h wide

struct RegionNode {
  enum class Kind : std::uint8_t { unresolved, leaf, branch, outside };
  // Bits of `below`: 1 << label for each label; other bits:
  static constexpr std::uint8_t unresolved_bit = 0x10;  // an unresolved node
  static constexpr std::uint8_t axis_bit = 0x20;        // a sparse leaf that is proven by its axis
  static constexpr std::uint8_t anything = 0x3f;

  std::int32_t children = -1;  // index of the first of eight
  std::int32_t parent = -1;
  Voxel low{};             // lowest voxel
  std::uint8_t level = 0;  // 2^level voxels wide
  Kind kind = Kind::unresolved;
  bool waits = false;          // an insertion may be stored here or below
  std::int32_t waiting = -1;   // of a branch: head of the list of insertions not yet passed to its children
  Label label = Label::blank;  // while unresolved: the last known label; it can only become better
  std::uint8_t below = anything;  // of a branch: bits of what is below; may hold extra bits, never too few
  std::array<float, 3> axis{};    // of the empty cone that proves a blank or sparse leaf; 0: none

  static std::uint8_t bit(Label label) {
    return static_cast<std::uint8_t>(1u << static_cast<unsigned>(label));
  }
  std::int32_t width() const { return 1 << level; }  // [voxels]
};

class RegionTree {
 public:
  RegionTree(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options);

  Label label_at(const Vec3& q);
  void inserted(const Vec3& at, std::span<const std::uint32_t> disturbed);
  void settle(const std::function<void(double)>& progress = {});

  // visit(node) for every resolved leaf inside the box.
  template <class Visit>
  void for_each_leaf(Visit&& visit) const {
    for (std::int32_t root = 0; root < roots_.size(); ++root) visit_leaves(root, visit);
  }
  Box box_of(const RegionNode& node) const;  // clipped to the box of the states
  const VoxelGrid& grid() const { return grid_; }
  const CoverageQuery& query() const { return query_; }
  double spacing_at(const Vec3& q) const;  // h(q) [m]
  double gap_radius(const Vec3& q) const;  // [m]

 private:
  const RegionNode& node(std::int32_t index) const { return pool_.nodes[index]; }
  template <class Visit>
  void visit_leaves(std::int32_t index, Visit& visit) const {
    const RegionNode& here = node(index);
    if (here.kind == RegionNode::Kind::leaf) visit(here);
    if (here.kind == RegionNode::Kind::branch)
      for (int child = 0; child < 8; ++child) visit_leaves(here.children + child, visit);
  }

  Label label_of(const Vec3& q, PathWalk& walk);  // from the indexes, not from the leaves
  Vec3 centre(const RegionNode& node) const { return grid_.middle(node.low, node.width()); }
  double reach(const RegionNode& node) const { return grid_.reach(node.low, node.width()); }
  bool outside(const RegionNode& node) const;
  void resolve(std::int32_t index);  // to a leaf, or to a branch of unresolved children
  void resolve_voxel(std::int32_t index);
  bool prove_far(RegionNode& node, const Thresholds& limits, const Vec3& q, double e, const Vec3& nearest);
  bool prove_sparse(RegionNode& node, const Thresholds& limits, const Vec3& q, double e, const Vec3& nearest);
  bool all_safe(const RegionNode& node, const Thresholds& limits);
  // The thresholds that hold throughout the node; null where h(q) varies.
  const Thresholds* limits_over(const RegionNode& node);
  void become_leaf(RegionNode& node, Label label, const Vec3& axis = Vec3::Zero());
  void branch(std::int32_t index);
  void collapse(std::int32_t index);
  void settle_below(std::int32_t index);
  bool is_fresh() const;  // no leaf was ever resolved, and no insertion waits
  void settle_fresh(const std::function<void(double)>& progress);
  std::exception_ptr settle_root(const RegionNode& root);
  void take_root(std::int32_t root, RegionTree& part);  // moves the nodes below the only root of `part` here
  void watch_cell(std::int32_t index);                  // watches the cell that walk_ has found
  bool watch_place(const Vec3& q, std::int32_t index);
  void settle_marked();
  void refresh_above(std::int32_t index);
  bool reaches(const RegionNode& node, const Vec3& at) const;
  void pass_to(std::int32_t index,
               const Vec3& at);          // an insertion to a node: marks a leaf, is stored with a branch
  void pass_on(std::int32_t index);      // what a branch has stored, to its children
  void pass_on_all(std::int32_t index);  // and from them to all below
  bool breaks(const RegionNode& leaf, const Vec3& at) const;
  void mark(std::int32_t index);
  std::uint8_t summary(const RegionNode& node) const;

  struct SpacingLimits {
    explicit SpacingLimits(const StateSpaceOptions& options);
    double spacing;                                  // [m]
    std::shared_ptr<const AdaptiveLattice> lattice;  // null where the spacing is the same everywhere
    Thresholds usual;                                // at the spacing that the regions are made for
    Thresholds widest;                               // at the coarsest spacing of the lattice
    Thresholds scaled;                               // storage of what limits_over() returns
  };
  struct NodePool {
    SignedVector<RegionNode> nodes;
    std::vector<std::int32_t> free;  // first of eight unused nodes, each
  };
  struct WishedWatch {
    const void* cell;  // null: of the cell at q
    Vec3 q;
    StateId near;
    std::int32_t index;
  };
  struct Watches {
    std::vector<std::int32_t> restless;  // voxels that no watch covers: marked by every insertion
    std::vector<WishedWatch> wished;     // only where postponed
    bool postponed = false;              // a part of the tree must not change the triangulation
  };
  struct Insertion {
    Vec3 at;
    std::int32_t next;
  };
  struct Insertions {
    SignedVector<Insertion> all;  // linked lists, one a node
    std::vector<std::int32_t> free;
    std::vector<std::int32_t> roots;
  };
  struct Progress {
    std::vector<std::int32_t> marked;  // since settle() last resolved all leaves
    bool complete = false;  // settle() resolved all leaves once; unresolved ones lie below `marked`
  };

  DelaunayIndex& delaunay_;
  CoverageQuery query_;
  SpacingLimits thresholds_;
  VoxelGrid grid_;
  RootCubes roots_;
  NodePool pool_;
  Watches watches_;
  Insertions waiting_;
  PathWalk walk_;
  FarProof far_;
  Progress progress_;
};

inline bool RegionTree::outside(const RegionNode& node) const {
  return node.low[0] >= grid_.count[0] || node.low[1] >= grid_.count[1] || node.low[2] >= grid_.count[2];
}

inline void RegionTree::become_leaf(RegionNode& node, Label label, const Vec3& axis) {
  node.kind = RegionNode::Kind::leaf;
  node.label = label;
  for (unsigned i = 0; i < 3; ++i) node.axis[i] = static_cast<float>(axis[i]);
}

}  // namespace forefeel
