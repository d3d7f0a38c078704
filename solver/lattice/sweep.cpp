#include "solver/lattice/sweep.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "geometry/common/simd.hpp"

namespace forefeel {
namespace {

using SteadyClock = std::chrono::steady_clock;

// A state is checked by a solve along its straight path if its force differs by more than this share from the
// one that a neighbour's stiffness predicts; with an inverted element, from the cubic through the corners of
// its cell.
constexpr double suspicious = 0.1, suspicious_inverted = 1e-2;
constexpr double coarse_tolerance = 1e-7;
constexpr int prediction_iterations = 12;  // of Newton from a prediction, before the straight path is used
constexpr double fallback_tolerance = 1e-8;
constexpr int fallback_iterations = 60;
constexpr int stiffness_rounds = 10;
constexpr double far_off = 0.15;  // relative residual of a prediction

// One corner's contribution in predict_hermite.
FOREFEEL_CLONES void add_corner(std::size_t size, const double* __restrict u, const double* __restrict v,
                                double share, const double* move, const double* slope, const double* keep,
                                double* __restrict to, double* __restrict tangent) {
  const double* __restrict va = v, * __restrict vb = v + size, * __restrict vc = v + 2 * size;
  double* __restrict ta = tangent, * __restrict tb = tangent + size, * __restrict tc = tangent + 2 * size;
  const double ma = 0.5 * move[0], mb = 0.5 * move[1], mc = 0.5 * move[2];
  const double sa = slope[0], sb = slope[1], sc = slope[2], ka = keep[0], kb = keep[1], kc = keep[2];
  for (std::size_t i = 0; i < size; ++i) {
    const double a = ma * va[i], b = mb * vb[i], c = mc * vc[i], all = u[i] + a + b + c;
    to[i] += share * all;
    ta[i] += sa * (all - a) + ka * va[i];
    tb[i] += sb * (all - b) + kb * vb[i];
    tc[i] += sc * (all - c) + kc * vc[i];
  }
}

void scale_into(const std::vector<double>& from, double factor, std::vector<double>& to) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * from[i];
}

}  // namespace

SweepWorker::SweepWorker(std::shared_ptr<const Discretisation> discretisation, const SweepOptions& options)
    : d_(std::move(discretisation)), options_(options), path_(d_), lanes_(d_) {}

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
  if (starts.empty() || s.status == SolveStatus::cancelled) return;
  const SweepNode& start = *starts.front();
  path_.begin_at(start.state.at, start.field);
  const NewtonReport report = path_.advance(s.at, 0, fallback_tolerance, fallback_iterations, options_.stop);
  if (report.status != SolveStatus::converged)
    return;  // keeps the status of the straight path: it is the reason
  s.parent = start.state.at;
  s.multivalued = true;
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
  const bool inverted = s.min_jacobian <= 0;
  if (inverted && (coarse || neighbours.empty())) return true;
  Vec3 mean = Vec3::Zero();
  for (const SweepNode* other : neighbours) {
    const State& o = other->state;
    mean += (o.force - 0.5 * o.stiffness * (s.at - o.at)) / static_cast<double>(neighbours.size());
  }
  if (jumps(node, neighbours)) return true;
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

void SweepWorker::take(SweepNode& node, const NewtonReport& report) {
  State& s = node.state;
  s.status = report.status;
  s.force = report.force;
  s.energy = report.energy;
  s.stiffness = path_.stiffness();
  s.residual = report.residual;
  s.min_jacobian = report.min_jacobian;
  s.iterations += path_.iterations();
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
  node.state.status = SolveStatus::stalled;
  // next to a state with an inverted element a prediction is unreliable
  if (!parents.empty() && parents.front()->state.min_jacobian > 0) {
    const SweepNode& parent = *parents.front();
    node.state.parent = parent.state.at;
    const Vec3 move = node.state.at - parent.state.at;
    LocalField slope = parent.field;
    if (beyond) {  // V is extrapolated linearly along the three nodes
      scale_into(parent.field.tangent, 0.5, slope.tangent);
      scale_into(beyond->field.tangent, -0.5, slope.tangent);
    }
    detail::predict(*d_, slope, move, node.state.at, node.field.u);
    correct_alone(node);
  }
  if (!node.solved() || doubtful(node, parents, true)) {
    walk({&node});
    if (!node.solved()) fall_back(node, parents);
    if (node.solved() && jumps(node, parents)) node.state.multivalued = true;
  }
  node.state.seconds = std::chrono::duration<double>(SteadyClock::now() - start).count();
}

// The axes along which the node lies between two corners, and the step [m] by which it lies beyond all corners along
// the others (zero inside). Nothing if some of the corners that this needs are not known.
std::optional<SweepWorker::Place> SweepWorker::place_of(const SweepNode& node,
                                                        const std::vector<const SweepNode*>& corners) const {
  Place place;
  std::size_t wanted = 1;
  for (std::size_t j = 0; j < 3; ++j) {
    if (node.index[j] % 2 == 0) continue;
    const auto axis = static_cast<int>(j);
    const auto low = std::ranges::count_if(
        corners, [&](const SweepNode* c) { return c->state.at[axis] < node.state.at[axis]; });
    const auto all = static_cast<std::ptrdiff_t>(corners.size());
    place.between[j] = low > 0 && low < all;
    if (place.between[j])
      wanted *= 2;
    else
      place.beyond[axis] = low > 0 ? options_.spacing : -options_.spacing;
  }
  if (corners.size() != wanted) return std::nullopt;
  return place;
}

// The field at c + d, outside of the corners, from the cubic through u and V of c and of the corner c - 2d:
//   u = u_b + 3/4 V_b d + 9/4 V_c d    V = 3/2 V_c - 1/2 V_b
// or from the tangent of c if c - 2d is not nearer to rest or not known.
LocalField SweepWorker::extrapolated(const SweepNode& corner, const Vec3& step) const {
  LatticeIndex b = corner.index;
  bool inward = true;
  for (std::size_t j = 0; j < 3; ++j) {
    const double along = step[static_cast<int>(j)];
    b[j] -= along > 0 ? 1 : along < 0 ? -1 : 0;
    inward = inward && std::abs(b[j]) <= std::abs(corner.index[j]);
  }
  const SweepNode* inner = inward && options_.coarse ? options_.coarse(b) : nullptr;
  LocalField field;
  if (!inner) {
    field.tangent = corner.field.tangent;
    detail::predict(*d_, corner.field, step, corner.state.at + step, field.u);
    return field;
  }
  const std::size_t size = corner.field.u.size();
  field.u = inner->field.u;
  field.tangent.resize(3 * size);
  const double *vb = inner->field.tangent.data(), *vc = corner.field.tangent.data();
  for (std::size_t c = 0; c < 3; ++c) {
    const double along = step[static_cast<int>(c)];
    for (std::size_t i = 0; i < size; ++i)
      field.u[i] += along * (0.75 * vb[c * size + i] + 2.25 * vc[c * size + i]);
  }
  for (std::size_t i = 0; i < 3 * size; ++i) field.tangent[i] = 1.5 * vc[i] - 0.5 * vb[i];
  return field;
}

// u = mean of u_c + V_c (x - x_c)/2 over the corners; along an axis j between two corners the tangent is the
// derivative of the cubic there, 3/2 (u+ - u-)/(2h) - V_j/2, and elsewhere the corners' mean. Where the node lies
// outside of the corners, each is first moved outward with it.
bool SweepWorker::predict_hermite(SweepNode& node, const std::vector<const SweepNode*>& corners) const {
  const std::optional<Place> place = place_of(node, corners);
  if (!place) return false;
  const double share = 1.0 / static_cast<double>(corners.size()), h = options_.spacing;
  LocalField& f = node.field;
  const std::size_t size = static_cast<std::size_t>(d_->local_size());
  f.u.assign(size, 0.0);
  f.tangent.assign(3 * size, 0.0);
  for (const SweepNode* corner : corners) {
    LocalField moved;
    if (!place->beyond.isZero(0)) moved = extrapolated(*corner, place->beyond);
    const LocalField& from = moved.u.empty() ? corner->field : moved;
    Vec3 move = node.state.at - corner->state.at, slope, keep;
    for (int j = 0; j < 3; ++j) {
      const bool mid = place->between[static_cast<std::size_t>(j)];
      if (!mid) move[j] = 0;
      // the state lies at +h along j from this corner: the corner is on the low side
      slope[j] = mid ? (move[j] > 0 ? -1.5 : 1.5) / h * share : 0.0;
      keep[j] = (mid ? -0.5 : 1.0) * share;
    }
    add_corner(size, from.u.data(), from.tangent.data(), share, move.data(), slope.data(), keep.data(),
               f.u.data(), f.tangent.data());
  }
  return true;
}

void SweepWorker::predict_fine(SweepNode& node, const std::vector<const SweepNode*>& corners) const {
  if (!predict_hermite(node, corners)) {
    const SweepNode& corner = *corners.front();
    node.field.tangent = corner.field.tangent;
    detail::predict(*d_, corner.field, node.state.at - corner.state.at, node.state.at, node.field.u);
  }
  for (int i = 0; i < 3; ++i)
    node.field.u[static_cast<std::size_t>(3 * d_->free_nodes + i)] = node.state.at[i];
}

void SweepWorker::solve_cell(std::vector<SweepNode>& nodes,
                             const std::vector<std::vector<const SweepNode*>>& corners) {
  const auto start = SteadyClock::now();
  std::vector<SweepNode*> together;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i].state.status = SolveStatus::stalled;
    if (corners[i].empty()) continue;
    nodes[i].state.parent = corners[i].front()->state.at;
    predict_fine(nodes[i], corners[i]);
    together.push_back(&nodes[i]);
  }
  if (!together.empty()) run_lanes(together);
  for (SweepNode* node : together)
    if (!node->solved()) correct_alone(*node);
  const double each = std::chrono::duration<double>(SteadyClock::now() - start).count() /
                      static_cast<double>(std::max<std::size_t>(1, nodes.size()));
  const auto later = SteadyClock::now();
  std::vector<SweepNode*> walking;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (!nodes[i].solved() || doubtful(nodes[i], corners[i], false)) walking.push_back(&nodes[i]);
  if (!walking.empty()) walk(walking);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i].state.seconds = each;
    if (std::find(walking.begin(), walking.end(), &nodes[i]) == walking.end()) continue;
    if (!nodes[i].solved()) fall_back(nodes[i], corners[i]);
    if (nodes[i].solved() && jumps(nodes[i], corners[i])) nodes[i].state.multivalued = true;
  }
  for (SweepNode* node : walking)
    node->state.seconds += std::chrono::duration<double>(SteadyClock::now() - later).count() /
                           static_cast<double>(walking.size());
}

}  // namespace forefeel
