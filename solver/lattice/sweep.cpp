#include "solver/lattice/sweep.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace forefeel {

bool CoarsePlanes::holds(const LatticeIndex& k) const {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::ranges::binary_search(at[axis], k[axis])) return false;
  return true;
}

std::optional<std::pair<int, int>> CoarsePlanes::around(std::size_t axis, double q) const {
  constexpr double rounding = 1e-6;
  const std::vector<int>& planes = at[axis];
  const auto high = std::ranges::lower_bound(planes, q - rounding, {}, [](int k) { return double(k); });
  if (high == planes.end()) return std::nullopt;
  if (*high <= q + rounding) return std::pair{*high, *high};
  if (high == planes.begin()) return std::nullopt;
  return std::pair{*(high - 1), *high};
}

std::optional<int> CoarsePlanes::next(std::size_t axis, int k, int side) const {
  const std::vector<int>& planes = at[axis];
  const auto here = std::ranges::lower_bound(planes, k);
  if (side < 0) return here == planes.begin() ? std::nullopt : std::optional(*(here - 1));
  return planes.end() - here < 2 ? std::nullopt : std::optional(*(here + 1));
}

std::vector<LatticeIndex> inner_corners(const CoarsePlanes& planes, const LatticeIndex& coarse) {
  std::vector<LatticeIndex> corners{coarse};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (coarse[axis] == 0) continue;
    const auto next = planes.next(axis, coarse[axis], coarse[axis] > 0 ? -1 : 1);
    if (!next) continue;
    for (std::size_t i = 0, count = corners.size(); i < count; ++i) {
      corners.push_back(corners[i]);
      corners.back()[axis] = *next;
    }
  }
  return corners;
}

CoarsePlanes coarse_planes(const Box& box, double spacing) {
  CoarsePlanes planes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // the first and the last position of lattice() (state_space.hpp)
    const auto i = static_cast<int>(axis);
    const int low = static_cast<int>(std::ceil(box.low[i] / spacing - 1e-9)),
              high = static_cast<int>(std::floor(box.high[i] / spacing + 1e-9));
    for (int k = low; k <= high; ++k)
      if (k % 2 == 0 || k == low || k == high) planes.at[axis].push_back(k);
  }
  return planes;
}

namespace {

using SteadyClock = std::chrono::steady_clock;

// A state is checked by a solve along its straight path if its force differs by more than this share from the
// one that a neighbour's stiffness predicts; with an inverted element, from the cubic through the corners of
// its cell.
constexpr double suspicious = 0.1, suspicious_inverted = 1e-2;
constexpr double bent =
    0.4;  // misfit() over the distance, beyond which a coarse state is checked in the same way
constexpr double coarse_tolerance = 1e-7;
constexpr int prediction_iterations = 12;  // of Newton from a prediction, before the straight path is used
constexpr double fallback_tolerance = 1e-8;
constexpr int fallback_iterations = 60;
constexpr int stiffness_rounds = 10;
constexpr double far_off = 0.15;  // relative residual of a prediction

double seconds_since(SteadyClock::time_point start) {
  return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

void scale_into(const std::vector<double>& from, double factor, std::vector<double>& to) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * from[i];
}

}  // namespace

SweepWorker::SweepWorker(std::shared_ptr<const Discretisation> discretisation, const SweepOptions& options)
    : d_(std::move(discretisation)), options_(options), path_(d_, options.precision), lanes_(d_) {}

// Newton from the prediction.
void SweepWorker::correct_alone(SweepNode& node) {
  const NewtonReport report =
      path_.correct(node.field.u, node.state.at, coarse_tolerance, prediction_iterations, options_.stop);
  if (report.status == SolveStatus::converged) take(node, report);
}

// Used if the straight path does not arrive: continuation from the first of the given nodes. It finds some equilibrium,
// not necessarily the one on the reference branch.
void SweepWorker::fall_back(SweepNode& node, const std::vector<const SweepNode*>& starts) {
  State& s = node.state;
  node.field = {};
  if (starts.empty() || s.solve.status == SolveStatus::cancelled) return;
  const SweepNode& start = *starts.front();
  path_.begin_at(start.state.at, start.field);
  const NewtonReport report = path_.advance(s.at, 0, fallback_tolerance, fallback_iterations, options_.stop);
  if (report.status != SolveStatus::converged)
    return;  // keeps the status of the straight path: it is the reason
  s.solve.parent = start.state.at;
  s.solve.multivalued = true;
  take(node, report);
}

// The trapezium rule on the stiffnesses predicts the force to third order, their Hermite mean over the
// corners of a cell to fourth. If the force differs from the prediction, or if a neighbour is known to have
// another branch, the straight path from rest in steps of h decides. With an inverted element there is
// usually another equilibrium, so a coarse state with one (from which fine states are predicted) is always
// solved along its straight path.
bool SweepWorker::doubtful(const SweepNode& node, const std::vector<const SweepNode*>& neighbours,
                           bool coarse) const {
  const State& s = node.state;
  const bool inverted = s.solve.min_jacobian <= 0;
  if (inverted && (coarse || neighbours.empty())) return true;
  Vec3 mean = Vec3::Zero();
  for (const SweepNode* other : neighbours) {
    const State& o = other->state;
    mean += (o.force - 0.5 * o.stiffness * (s.at - o.at)) / static_cast<double>(neighbours.size());
  }
  if (jumps(node, neighbours) || (coarse && bends(node, neighbours))) return true;
  return inverted &&
         !((mean - s.force).norm() <= suspicious_inverted * std::max(s.force.norm(), d_->force_floor));
}

bool SweepWorker::jumps(const SweepNode& node, const std::vector<const SweepNode*>& neighbours) const {
  const State& s = node.state;
  return std::any_of(neighbours.begin(), neighbours.end(), [&](const SweepNode* other) {
    const State& o = other->state;
    const Vec3 foretold = o.force - 0.5 * (o.stiffness + s.stiffness) * (s.at - o.at);
    return !((foretold - s.force).norm() <=
             suspicious * std::max({s.force.norm(), o.force.norm(), d_->force_floor}));
  });
}

// True if the displacements between the node and a neighbour are far from smooth: some elements have changed their
// equilibrium on the way. The force may show little of it.
bool SweepWorker::bends(const SweepNode& node, const std::vector<const SweepNode*>& neighbours) const {
  return std::any_of(neighbours.begin(), neighbours.end(), [&](const SweepNode* other) {
    const Vec3 move = node.state.at - other->state.at;
    return misfit(other->field, node.field, move) > bent * move.norm();
  });
}

void SweepWorker::take(SweepNode& node, const NewtonReport& report) {
  State& s = node.state;
  s.solve.status = report.status;
  s.force = report.force;
  s.energy = report.energy;
  s.stiffness = path_.stiffness();
  s.solve.residual = report.residual;
  s.solve.min_jacobian = report.min_jacobian;
  s.solve.iterations += path_.iterations();
  node.field = path_.field();
}

// Solves up to eight states with one factor at the mean of their predictions. States whose prediction is far from an
// equilibrium would need another factor and are left out.
void SweepWorker::run_lanes(std::vector<SweepNode*> nodes) {
  std::vector<LocalField*> fields;
  const auto take_fields = [&] {
    fields.clear();
    for (SweepNode* node : nodes) fields.push_back(&node->field);
  };
  take_fields();
  const std::array<double, lane_count> residual = lanes_.residuals(fields);
  std::vector<SweepNode*> near;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (residual[i] <= far_off) near.push_back(nodes[i]);
  if (near.empty()) return;
  nodes = near;
  take_fields();
  std::vector<double> middle(fields.front()->u.size(), 0.0);
  for (const LocalField* field : fields)
    scale_into(field->u, 1.0 / static_cast<double>(fields.size()), middle);
  if (!path_.newton().factorise_shifted(middle)) return;
  std::array<LaneResult, lane_count> results;
  lanes_.solve(path_.newton().factor(), fields, options_.residual_tolerance, results, stiffness_rounds,
               &path_.newton());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!results[i].converged) continue;
    if (!results[i].stiffness_settled && !detail::condense_alone(path_.newton(), nodes[i]->field, results[i]))
      continue;
    detail::copy_result(results[i], nodes[i]->state);
  }
}

void SweepWorker::solve_coarse(SweepNode& node, const std::vector<const SweepNode*>& parents,
                               const SweepNode* beyond) {
  const auto start = SteadyClock::now();
  node.state.solve.status = SolveStatus::stalled;
  // next to a state with an inverted element a prediction is unreliable
  if (!parents.empty() && parents.front()->state.solve.min_jacobian > 0) {
    node.state.solve.parent = parents.front()->state.at;
    predict_coarse(node, parents, beyond);
    correct_alone(node);
  }
  if (!node.solved() || doubtful(node, parents, true)) {
    walk(node, find_anchors({&node}).front());
    if (!node.solved()) fall_back(node, parents);
    if (node.solved() && jumps(node, parents)) node.state.solve.multivalued = true;
  }
  node.state.solve.seconds = seconds_since(start);
}

void SweepWorker::solve_together(SweepCell& cell) {
  const auto start = SteadyClock::now();
  std::vector<SweepNode*> together;
  for (std::size_t i = 0; i < cell.nodes.size(); ++i) {
    SweepNode& node = cell.nodes[i];
    node.state.solve.status = SolveStatus::stalled;
    if (cell.corners[i].empty()) continue;
    node.state.solve.parent = cell.corners[i].front()->state.at;
    predict_fine(node, cell.corners[i]);
    together.push_back(&node);
  }
  if (!together.empty()) run_lanes(together);
  cell.open.clear();
  const double each = seconds_since(start) / static_cast<double>(std::max<std::size_t>(1, cell.nodes.size()));
  for (std::size_t i = 0; i < cell.nodes.size(); ++i) {
    cell.nodes[i].state.solve.seconds = each;
    if (!cell.nodes[i].solved() && !cell.corners[i].empty()) cell.open.push_back(i);
  }
}

void SweepWorker::correct(SweepCell& cell, std::size_t place) {
  const auto start = SteadyClock::now();
  SweepNode& node = cell.nodes[cell.open[place]];
  correct_alone(node);
  node.state.solve.seconds += seconds_since(start);
}

void SweepWorker::find_paths(SweepCell& cell) {
  const auto start = SteadyClock::now();
  cell.open.clear();
  std::vector<SweepNode*> walking;
  for (std::size_t i = 0; i < cell.nodes.size(); ++i) {
    if (cell.nodes[i].solved() && !doubtful(cell.nodes[i], cell.corners[i], false)) continue;
    cell.open.push_back(i);
    walking.push_back(&cell.nodes[i]);
  }
  if (walking.empty()) return;
  cell.anchors = find_anchors(walking);
  const double each = seconds_since(start) / static_cast<double>(walking.size());
  for (SweepNode* node : walking) node->state.solve.seconds += each;
}

void SweepWorker::follow_path(SweepCell& cell, std::size_t place) {
  const auto start = SteadyClock::now();
  const std::size_t i = cell.open[place];
  SweepNode& node = cell.nodes[i];
  walk(node, cell.anchors[place]);
  if (!node.solved()) fall_back(node, cell.corners[i]);
  if (node.solved() && jumps(node, cell.corners[i])) node.state.solve.multivalued = true;
  node.state.solve.seconds += seconds_since(start);
}

}  // namespace forefeel
