#pragma once
// What a sweep has to solve, and what each piece of it needs (the method: sweep.hpp). A piece is a coarse node or a
// cell, named by the coarse index of the node or of the cell's lowest corner. All coarse nodes that a piece looks at
// are nearer to rest, or corners of the cell.

#include <functional>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "solver/lattice/generate_options.hpp"
#include "solver/lattice/sweep.hpp"

namespace forefeel {

LatticeIndex fine_index(const Vec3& x, double spacing);
Vec3 position_of(const LatticeIndex& k, double spacing);
int level(const LatticeIndex& k);  // steps along the axes to rest
// One step towards rest along an axis; the axes are tried from the longest component down.
std::vector<LatticeIndex> towards_rest(const LatticeIndex& k);

class SweepPlan {
 public:
  // Everything in the box but what `known` holds.
  SweepPlan(const GenerateOptions& options, const std::vector<State>& known);

  std::size_t positions() const { return all_.size(); }  // of the lattice in the box
  std::size_t resumed() const { return positions() - missing_.size(); }
  const std::vector<LatticeIndex>& missing() const { return missing_; }  // fine indices, outward from rest
  bool is_wanted(const LatticeIndex& fine) const { return wanted_.contains(fine); }
  // The coarse nodes that missing states depend on, with all on the paths from rest to them; sorted by index.
  const std::vector<LatticeIndex>& coarse() const { return coarse_; }
  const std::vector<LatticeIndex>& cells() const {
    return cells_;
  }  // with missing fine states, outward from rest
  // The fine positions of a cell in the box, all of them: values do not depend on what a resumed file holds.
  std::vector<LatticeIndex> fine_of(const LatticeIndex& cell) const;

 private:
  void plan_coarse();
  void plan_cells();
  std::set<LatticeIndex> all_, wanted_;
  std::vector<LatticeIndex> missing_, coarse_, cells_;
};

// The solved coarse node of that index, or null.
using SolvedNodes = std::function<const SweepNode*(const LatticeIndex&)>;

SweepOptions sweep_options(const Body& body, const GenerateOptions& options, const std::stop_token& stop,
                           SolvedNodes solved);
SweepNode solve_coarse_node(SweepWorker& worker, const LatticeIndex& coarse, double spacing,
                            const SolvedNodes& solved);
std::vector<SweepNode> solve_fine_nodes(SweepWorker& worker, std::span<const LatticeIndex> fine,
                                        double spacing, const SolvedNodes& solved);
// The node's state, with the displacements of all nodes of the body if they are wanted.
State state_of(const SweepNode& node, const Discretisation& d, const Body& body, bool want_displacements);
// Every coarse node that solving these fine positions may look at, and possibly more; without the positions
// themselves. Sorted.
std::vector<LatticeIndex> nodes_looked_at(std::span<const LatticeIndex> fine, double spacing);

}  // namespace forefeel
