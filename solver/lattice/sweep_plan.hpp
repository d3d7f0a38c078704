#pragma once
// Plans a sweep (sweep.hpp): which pieces must be solved, and which solved nodes each piece needs. A coarse node needs
// only coarse nodes nearer to rest; a group of fine states may also need the corners of its cells.

#include <algorithm>
#include <functional>
#include <span>
#include <vector>

#include "solver/lattice/generate.hpp"
#include "solver/lattice/sweep.hpp"

namespace forefeel {

LatticeIndex fine_index(const Vec3& x, double spacing);
Vec3 position_of(const LatticeIndex& k, double spacing);
int level(const LatticeIndex& k);  // steps along the axes to rest
// The coarse nodes one plane nearer to rest along an axis; the axes are tried from the longest component down.
std::vector<LatticeIndex> towards_rest(const CoarsePlanes& planes, const LatticeIndex& coarse);

class SweepPlan {
 public:
  // Plans all lattice positions in the box that `known` does not hold.
  SweepPlan(const LatticeOptions& options, const std::vector<State>& known);

  std::size_t positions() const { return positions_; }  // of the lattice in the box
  std::size_t resumed() const { return positions() - missing_.size(); }
  const std::vector<LatticeIndex>& missing() const { return missing_; }  // fine indices, outward from rest
  bool is_wanted(const LatticeIndex& fine) const { return std::ranges::binary_search(wanted_, fine); }
  // The coarse nodes that missing states depend on, with all on the paths from rest to them; sorted by index.
  const std::vector<LatticeIndex>& coarse() const { return coarse_; }
  const CoarsePlanes& planes() const { return planes_; }
  // The fine positions with missing states, in groups that are solved together, outward from rest. A group holds all
  // fine positions of a coarse cell, or of a few small neighbouring cells at the border of the box. It includes those
  // already known, so that the values do not depend on what a resumed file holds.
  const std::vector<std::vector<LatticeIndex>>& groups() const { return groups_; }

 private:
  void plan_coarse();
  void plan_groups(const std::vector<Vec3>& outward, double spacing);
  CoarsePlanes planes_;
  std::size_t positions_ = 0;
  std::vector<LatticeIndex> missing_, wanted_, coarse_;  // wanted_: those missing, sorted
  std::vector<std::vector<LatticeIndex>> groups_;
};

// A unit of work. It may start when all pieces that it waits for are solved: it looks at no other nodes.
struct SweepPiece {
  bool is_coarse = false;                // a coarse node; otherwise a group of fine states
  std::vector<LatticeIndex> states;      // that it solves
  std::size_t waits_for = 0;             // pieces
  std::vector<std::size_t> before = {};  // numbers of the pieces that wait for it
};

// All pieces of the plan, each after those that it waits for: coarse nodes first, both kinds outward from rest.
std::vector<SweepPiece> pieces_of(const SweepPlan& plan);

// The coarse nodes at the corners of the cells, or of the edges and faces, on which fine positions lie.
std::vector<LatticeIndex> corners_of(const CoarsePlanes& planes, std::span<const LatticeIndex> fine);

// The solved coarse node of that index, or null.
using SolvedNodes = std::function<const SweepNode*(const LatticeIndex&)>;

SweepOptions sweep_options(const Body& body, const LatticeOptions& options, const std::stop_token& stop,
                           SolvedNodes solved);
SweepNode solve_coarse_node(SweepWorker& worker, const LatticeIndex& coarse);
SweepCell cell_of(const SweepOptions& options, std::span<const LatticeIndex> fine);  // nothing solved
std::vector<SweepNode> solve_fine_nodes(SweepWorker& worker, std::span<const LatticeIndex> fine);
// The coarse nodes that solving these fine positions may need, and possibly some more. The positions themselves are
// not included. Sorted.
std::vector<LatticeIndex> nodes_looked_at(const CoarsePlanes& planes, std::span<const LatticeIndex> fine);

}  // namespace forefeel
