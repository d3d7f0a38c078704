#pragma once
// The two-level sweep of a lattice of spacing h [m], behind generate_lattice():
// 1. The coarse nodes, outward from rest. They lie where planes 2h apart, and the faces of the box, cross.
//    Each state is predicted from one node nearer to rest or from all nodes between it and rest, whichever gives
//    the least residual (sweep_predict.cpp). Newton corrects it, reusing a factor while it contracts.
// 2. The fine states of each coarse cell (seven of its eight), or of a few small cells at the border of the box. They
//    are predicted from the coarse corners around them by u = mean over c of u_c + V_c (x - x_c)/2, a cubic Hermite
//    value of error O(h^4). They are solved together with one factor, except those whose prediction is far from an
//    equilibrium: these are solved one by one by Newton.
// Some states do not contract, or do not match the states around them. These are solved along the straight path from
// rest (sweep_rays.cpp), which defines the reference branch. A state depends only on the body, the spacing, the box and
// its position: not on the number of threads, and not on what a resumed file already holds. Factors may be in single
// precision; residuals, forces and stiffnesses are in double precision.

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/common/types.hpp"
#include "solver/equilibrium/continuation.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

// The lattice planes of a sweep whose crossings are the coarse nodes: along each axis the even multiples of the spacing
// h and both ends of the box. Every lattice position between them lies halfway between two planes.

using LatticeIndex = std::array<int, 3>;  // x = h k

struct CoarsePlanes {
  std::array<std::vector<int>, 3> at;  // by axis, ascending

  bool holds(const LatticeIndex& k) const;  // a coarse node
  // The nearest planes with low <= q <= high; both are q on a plane; nothing outside of the box.
  std::optional<std::pair<int, int>> around(std::size_t axis, double q) const;
  // The next plane from the plane k to the lower (-1) or higher (1) side.
  std::optional<int> next(std::size_t axis, int k, int side) const;
};

// The node and the coarse nodes one plane nearer to rest along one or more axes: 1, 2, 4 or 8.
std::vector<LatticeIndex> inner_corners(const CoarsePlanes& planes, const LatticeIndex& coarse);

CoarsePlanes coarse_planes(const Box& box, double spacing);

struct SweepNode {
  LatticeIndex index{};
  State state;
  LocalField field;  // empty unless converged
  bool solved() const { return state.solve.status == SolveStatus::converged; }
};

struct SweepOptions {
  double spacing = 0.006;  // h [m]
  CoarsePlanes planes;
  Precision precision = Precision::exact;  // of the factors; fitting_precision()
  // Of the lanes, |r_f| / |f|. The force is corrected by V^T r_f afterwards and is far more accurate.
  double residual_tolerance = 1e-5;
  std::stop_token stop;
  // The solved coarse node, or null. Called only for nodes nearer to rest than the one being solved.
  std::function<const SweepNode*(const LatticeIndex&)> coarse;
};

// Where a straight path is entered: step number `step` of `steps` equal steps to the node; 0: at rest.
struct PathAnchor {
  int step = 0, steps = 1;
  LocalField field = {};
};

// The fine states of one cell under way. Four steps solve them: solve_together(), correct() for each of `open`,
// find_paths(), follow_path() for each of `open`. Any worker may take a step, or one place of `open`: hard states then
// do not wait for each other.
struct SweepCell {
  std::vector<SweepNode> nodes;
  std::vector<std::vector<const SweepNode*>> corners;  // by node: the solved coarse nodes around it
  std::vector<std::size_t> open = {};                  // nodes of the step that follows
  std::vector<PathAnchor> anchors = {};                // by place in open
};

// One thread's work space.
class SweepWorker {
 public:
  SweepWorker(std::shared_ptr<const Discretisation> discretisation, const SweepOptions& options);
  const SweepOptions& options() const { return options_; }

  // Solves a coarse node. parents: solved coarse nodes nearer to rest; the solve starts from the first (none:
  // from rest). beyond: the node opposite to this one across the first parent, or null.
  void solve_coarse(SweepNode& node, const std::vector<const SweepNode*>& parents, const SweepNode* beyond);

  void solve_together(SweepCell& cell);  // open: those without a solution
  void correct(SweepCell& cell, std::size_t place);
  void find_paths(SweepCell& cell);  // open: those that the straight path from rest decides
  void follow_path(SweepCell& cell, std::size_t place);

 private:
  void predict_coarse(SweepNode& node, const std::vector<const SweepNode*>& parents, const SweepNode* beyond);
  std::vector<double> extrapolated(const SweepNode& node, const SweepNode& parent,
                                   const SweepNode* beyond) const;
  std::optional<std::vector<double>> predict_mixed(const SweepNode& node) const;
  void predict_fine(SweepNode& node, const std::vector<const SweepNode*>& corners) const;
  bool predict_hermite(SweepNode& node, const std::vector<const SweepNode*>& corners) const;
  void take(SweepNode& node, const NewtonReport& report);  // of path_
  void fall_back(SweepNode& node, const std::vector<const SweepNode*>& starts);
  void correct_alone(SweepNode& node);
  bool doubtful(const SweepNode& node, const std::vector<const SweepNode*>& neighbours, bool coarse) const;
  bool jumps(const SweepNode& node, const std::vector<const SweepNode*>& neighbours) const;
  bool bends(const SweepNode& node, const std::vector<const SweepNode*>& neighbours) const;
  double misfit(const LocalField& from, const LocalField& to, const Vec3& move) const;

  void run_lanes(std::vector<SweepNode*> nodes);

  void walk(SweepNode& node, const PathAnchor& anchor);
  void drop_far(std::vector<LocalField*>& fields, std::vector<std::size_t>& candidates);
  std::vector<PathAnchor> find_anchors(const std::vector<SweepNode*>& nodes);
  std::vector<PathAnchor> candidates_of(const SweepNode& node, int steps) const;
  std::optional<double> predict_between(const SweepNode& node, const Vec3& x, LocalField& field) const;
  bool linked(const PathAnchor& anchor, const SweepNode& node) const;
  void settle(SweepNode& node, const NewtonReport& report);

  std::shared_ptr<const Discretisation> d_;
  SweepOptions options_;
  Continuation path_;
  LaneSolver lanes_;
};

}  // namespace forefeel
