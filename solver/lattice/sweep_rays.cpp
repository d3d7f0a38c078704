// The straight paths from rest of a sweep. The reference branch is defined by continuation straight from rest
// to x in n equal steps of at most h. Such a path runs through cells of the coarse lattice, whose corners are
// already solved. At the point x m/n the prediction
//   u = sum over the corners c of w_c (u_c + V_c (x m/n - x_c)/2),  w_c trilinear
// is exact to second order. If the iteration with a common factor reaches an equilibrium close to the prediction, that
// equilibrium and the corners lie on one branch, and the point is called an anchor. Continuation starts from the
// outermost anchor of the path, or from rest if there is none.
#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/lattice/sweep.hpp"

namespace forefeel {
namespace {

constexpr double between_tolerance = 1e-4;  // tolerance before the last step
constexpr double arrival_tolerance = 1e-7;
constexpr int most_ray_iterations = 60;
constexpr double other_branch = 1e-4;    // values on two branches differ by more than this share
constexpr double sheet_thickness = 0.2;  // [h] largest distance of an anchor from its prediction
constexpr double smooth_move = 0.08;     // [h] largest distance of a node from the end of a smooth step
constexpr double snap = 0.3;  // a kink above this: an element has snapped through, two equilibria are near
constexpr int last_steps = 4;
constexpr std::size_t most_easy = 4;      // candidates of a path without inverted elements around them
constexpr double far_from_anchor = 0.15;  // relative residual of a prediction

double distance(const std::vector<double>& a, const std::vector<double>& b, std::size_t rows) {
  double largest = 0;
  for (std::size_t i = 0; i < rows; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

}  // namespace

// The least det F over the corners, or nothing if not all of them are known.
std::optional<double> SweepWorker::predict_between(const SweepNode& node, const Vec3& x,
                                                   LocalField& field) const {
  const double spacing = options_.spacing;
  const std::size_t size = static_cast<std::size_t>(d_->local_size());
  field.u.assign(size, 0.0);
  field.tangent.assign(3 * size, 0.0);
  std::array<std::pair<int, int>, 3> cell;
  Vec3 share;
  double least = std::numeric_limits<double>::infinity();
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double q = x[axis] / spacing;
    const auto found = options_.planes.around(axis, q);
    if (!found) return std::nullopt;
    cell[axis] = *found;
    const int width = cell[axis].second - cell[axis].first;
    share[axis] = width > 0 ? (q - cell[axis].first) / width : 0.0;
  }
  for (int corner = 0; corner < 8; ++corner) {
    LatticeIndex c{};
    double weight = 1;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const bool high = ((corner >> axis) & 1) != 0;
      c[axis] = high ? cell[axis].second : cell[axis].first;
      weight *= high ? share[axis] : 1 - share[axis];
    }
    if (weight == 0) continue;
    if ((spacing * Vec3(c[0], c[1], c[2]) - node.state.at).norm() < 1e-6 * spacing)
      return std::nullopt;  // itself
    const SweepNode* known = options_.coarse ? options_.coarse(c) : nullptr;
    if (!known) return std::nullopt;
    least = std::min(least, known->state.solve.min_jacobian);
    const Vec3 half = 0.5 * (x - known->state.at);
    const double *u = known->field.u.data(), *v = known->field.tangent.data();
    for (std::size_t i = 0; i < size; ++i)
      field.u[i] += weight * (u[i] + half[0] * v[i] + half[1] * v[size + i] + half[2] * v[2 * size + i]);
    for (std::size_t i = 0; i < 3 * size; ++i) field.tangent[i] += weight * v[i];
  }
  std::copy_n(x.data(), 3, field.u.end() - 6);  // the contact; the clamp is last
  return least;
}

// The steps of a path at which an anchor is looked for: the last four, and further in until four have been found or no
// corner around one has an inverted element. Where elements are small, the last cells are often too large for a
// prediction.
std::vector<PathAnchor> SweepWorker::candidates_of(const SweepNode& node, int steps) const {
  std::vector<PathAnchor> candidates;
  for (int step = steps - 1; step > 0; --step) {
    PathAnchor candidate{step, steps, {}};
    const std::optional<double> least = predict_between(node, node.state.at * step / steps, candidate.field);
    const bool easy = least && *least > 0;
    if (least && (easy || step >= steps - last_steps)) candidates.push_back(std::move(candidate));
    if (easy && candidates.size() >= most_easy) break;
  }
  return candidates;
}

// Predictions that no iteration would take to an equilibrium nearby.
void SweepWorker::drop_far(std::vector<LocalField*>& fields, std::vector<std::size_t>& candidates) {
  if (fields.empty()) return;
  const std::array<double, lane_count> residual = lanes_.residuals(fields);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (!(residual[i] <= far_from_anchor)) continue;
    fields[kept] = fields[i];
    candidates[kept++] = candidates[i];
  }
  fields.resize(kept);
  candidates.resize(kept);
}

std::vector<PathAnchor> SweepWorker::find_anchors(const std::vector<SweepNode*>& nodes) {
  const std::size_t rows = static_cast<std::size_t>(3 * d_->free_nodes);
  std::vector<PathAnchor> anchors(nodes.size());
  std::vector<std::pair<std::size_t, PathAnchor>> candidates;  // with the node's place in nodes
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    anchors[i].steps =
        std::max(1, static_cast<int>(std::ceil(nodes[i]->state.at.norm() / options_.spacing * (1 - 1e-12))));
    for (PathAnchor& candidate : candidates_of(*nodes[i], anchors[i].steps))
      candidates.emplace_back(i, std::move(candidate));
  }
  // those that share a factor are at the same step
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.second.steps - a.second.step < b.second.steps - b.second.step;
  });
  for (std::size_t first = 0; first < candidates.size();) {
    std::vector<double> middle(rows + 6, 0.0);
    std::vector<LocalField*> fields;
    std::vector<std::size_t> taken;
    for (; first < candidates.size() && fields.size() < lane_count; ++first) {
      auto& [node, candidate] = candidates[first];
      if (candidate.step <= anchors[node].step) continue;  // it has an anchor further out
      taken.push_back(first);
      fields.push_back(&candidate.field);
    }
    drop_far(fields, taken);
    if (fields.empty()) continue;
    std::vector<LocalField> predicted;
    for (const LocalField* field : fields) predicted.push_back({field->u, {}});
    for (const LocalField* field : fields)
      for (std::size_t i = 0; i < middle.size(); ++i)
        middle[i] += field->u[i] / static_cast<double>(fields.size());
    if (!path_.newton().factorise(middle)) continue;
    std::array<LaneResult, lane_count> results;
    lanes_.solve(path_.newton().factor(), fields, between_tolerance, results, 1);
    for (std::size_t l = 0; l < fields.size(); ++l) {
      auto& [node, candidate] = candidates[taken[l]];
      if (!results[l].converged || candidate.step <= anchors[node].step) continue;
      if (distance(candidate.field.u, predicted[l].u, rows) > sheet_thickness * options_.spacing) continue;
      anchors[node] = std::move(candidate);
    }
  }
  return anchors;
}

// max |u_b - u_a - (V_a + V_b) move / 2| [m]: the error of the trapezium rule on V, large if the branch jumps between.
double SweepWorker::misfit(const LocalField& from, const LocalField& to, const Vec3& move) const {
  const std::size_t size = to.u.size(), rows = static_cast<std::size_t>(3 * d_->free_nodes);
  const double *va = from.tangent.data(), *vb = to.tangent.data();
  double largest = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    double left = to.u[i] - from.u[i];
    for (unsigned c = 0; c < 3; ++c) left -= 0.5 * move[c] * (va[c * size + i] + vb[c * size + i]);
    largest = std::max(largest, std::abs(left));
  }
  return largest;
}

// True if no jump lies between the anchor and the node's equilibrium.
bool SweepWorker::linked(const PathAnchor& anchor, const SweepNode& node) const {
  const Vec3 move = (1 - static_cast<double>(anchor.step) / anchor.steps) * node.state.at;
  return misfit(anchor.field, node.field, move) <= smooth_move * options_.spacing;
}

void SweepWorker::walk(SweepNode& node, const PathAnchor& anchor) {
  if (anchor.step > 0 && node.solved() && linked(anchor, node)) return;
  const Vec3& x = node.state.at;
  if (anchor.step > 0)
    path_.begin_at(x * anchor.step / anchor.steps, anchor.field);
  else
    path_.begin_at_rest();
  const double step = x.norm() / anchor.steps;
  settle(node,
         path_.advance(x, step, arrival_tolerance, most_ray_iterations, options_.stop, between_tolerance));
  if (path_.kink() > snap) node.state.solve.multivalued = true;
}

// report: of path_, at the node on the reference branch. Without it a solved node keeps its values and is
// marked.
void SweepWorker::settle(SweepNode& node, const NewtonReport& report) {
  State& s = node.state;
  const bool arrived = report.status == SolveStatus::converged;
  if (node.solved()) {
    if (arrived && (report.force - s.force).norm() <= other_branch * report.force.norm()) return;
    s.solve.multivalued = true;
    if (!arrived) return;
  }
  s.solve.parent = Vec3::Zero();
  if (arrived) {
    take(node, report);
    return;
  }
  s.solve.status = report.status;
  s.solve.iterations += path_.iterations();
  s.solve.residual = report.residual;
  s.solve.min_jacobian = report.min_jacobian;
}

}  // namespace forefeel
