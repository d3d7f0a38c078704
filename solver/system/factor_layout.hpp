#pragma once
// The fronts of a multifrontal factor and where their numbers lie: fixed by the pattern, shared by a body's factors.
// The tree of a large body is cut for threads that share one factor (share_out.hpp): `parts`, subtrees, and the `top`
// fronts above them, one after another. A part's update matrices are made in scratch space of its thread, which stays
// in the cache; only its root's is kept. A part meets the others in nodes of the top only. In a substitution it has
// rows of its own for them, its tail, behind those of the vector, and work space of its own.

#include <cstdint>
#include <vector>

#include "solver/kernels/kernels.hpp"
#include "solver/system/discretisation.hpp"

namespace forefeel {

// Multiplications of the elimination of so many nodes from a front with `rest` more.
double elimination_flops(double pivots, double rest);

struct FactorLayout {
  struct Subtree {
    Part fronts, nodes;               // nodes: of FactorLayout::met, those of the top that it meets
    std::int64_t tail = 0, work = 0;  // rows: of nodes behind the vector, of work space
    std::int64_t kept = 0;            // where its root's update matrix is copied to, if the tree is cut
    double flops = 0;
  };
  std::vector<Front> fronts;
  std::vector<Front> fronts_of_top;  // the same with `update` where the roots of parts are kept: for the top
  std::vector<std::int32_t> rows, children, place, met;
  std::vector<ExtendRun> runs;
  std::vector<std::int64_t> row_start;
  std::vector<Subtree> parts;     // the costliest first; one of all fronts: nothing to share
  std::vector<std::int64_t> top;  // in elimination order
  struct Sizes {
    std::int64_t free_nodes = 0, panel = 0, stack = 0, scratch = 0, tails = 0;
    std::int64_t work = 0, top_work = 0;  // rows of work space: all, and where those of the top begin
    std::int64_t padding = 0;             // of rows
    double flops = 0;
  } size;

  FactorLayout(const BlockPattern& pattern, std::int64_t free_nodes, std::int64_t padding);

  std::size_t panels() const { return static_cast<std::size_t>(size.panel + 2 * size.padding); }
  std::size_t stacks() const { return static_cast<std::size_t>(size.stack + 2 * size.padding); }
  std::size_t scratches() const { return static_cast<std::size_t>(size.scratch + 2 * size.padding); }
  const Front& root(const Subtree& part) const { return at(part.fronts.first + part.fronts.count - 1); }
  FrontTree tree() const;
  FrontTree tree_of_top() const;

 private:
  const Front& at(std::int64_t front) const { return *(fronts.begin() + front); }
  std::int32_t position(const Front& f, std::int32_t node) const;
  void place_fronts(const BlockPattern& pattern);
  void place_blocks(const BlockPattern& pattern);
  void cut();
  std::int64_t place_stacks(const std::vector<std::int64_t>& of, std::int64_t base);
  void place_tail(Subtree& part);
};

}  // namespace forefeel
