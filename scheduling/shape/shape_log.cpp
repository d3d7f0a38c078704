#include "scheduling/shape/shape_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/common/error.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {
namespace {

// V of the given nodes: du_i/dx_c [1], row by row.
std::vector<float> slope_at_rest(const std::shared_ptr<const Body>& body,
                                 const std::vector<NodeIndex>& nodes) {
  Solver solver(body);
  const SolveOutcome rest = solver.reference(Vec3::Zero(), 1);
  if (!rest.equilibrium || rest.equilibrium->tangent.empty())
    throw InputError("session.shape_rate",
                     "needs the stiffness of the body at rest, which is not stable there");
  std::vector<float> slope;
  slope.reserve(9 * nodes.size());
  for (const NodeIndex node : nodes)
    for (std::size_t k = 0; k < 9; ++k)
      slope.push_back(static_cast<float>(rest.equilibrium->tangent[9 * static_cast<std::size_t>(node) + k]));
  return slope;
}

bool is_shapeable(const State& state, const Body& body) {
  return state.displacements && state.displacements->size() == 3 * body.mesh.nodes.size();
}

}  // namespace

ShapeLog::ShapeLog(std::shared_ptr<const Body> body, const ShapeOptions& options, EachShape each)
    : body_(std::move(body)), options_(options), each_(std::move(each)) {
  check(options_);
  if (options_.surface) {
    nodes_ = surface_nodes(body_->mesh);
  } else {
    nodes_.resize(body_->mesh.nodes.size());
    std::iota(nodes_.begin(), nodes_.end(), NodeIndex{0});
  }
  slope_ = slope_at_rest(body_, nodes_);
}

void ShapeLog::learn(const State& state) {
  check_shapeable({&state, 1}, *body_, "a solved state");
  known_.at.push_back(state.at);
  known_.moved.push_back(state.displacements);
}

// Chooses the nearest states. States at rest are skipped, because every shape contains rest and its slope.
void ShapeLog::choose_near(const Vec3& at) {
  present_.near.resize(known_.at.size());
  std::iota(present_.near.begin(), present_.near.end(), 0u);
  std::erase_if(present_.near, [&](std::uint32_t id) { return known_.at[id].norm() < 1e-9; });
  const std::size_t few = std::min(options_.neighbours, present_.near.size());
  const auto middle = present_.near.begin() + static_cast<std::ptrdiff_t>(few);
  std::ranges::nth_element(present_.near, middle, [&](std::uint32_t a, std::uint32_t b) {
    const double da = (known_.at[a] - at).squaredNorm(), db = (known_.at[b] - at).squaredNorm();
    return da != db ? da < db : a < b;
  });
  present_.near.resize(few);
  std::ranges::sort(present_.near);
  present_.places.clear();
  for (const std::uint32_t id : present_.near) present_.places.push_back(known_.at[id]);
}

void ShapeLog::take(double t, const Vec3& at) {
  choose_near(at);
  const ShapeWeights weights = shape_weights(at, present_.places);
  ShapeRecord record{.t = t,
                     .at = at,
                     .known = static_cast<std::uint32_t>(known_.at.size()),
                     .states = {},
                     .weights = {},
                     .slope = weights.of_slope,
                     .order = weights.order};
  for (std::size_t i = 0; i < present_.near.size(); ++i) {
    if (weights.of_states[i] == 0) continue;
    record.states.push_back(present_.near[i]);
    record.weights.push_back(static_cast<float>(weights.of_states[i]));
  }
  displacements(record, present_.u);
  double largest = 0;
  for (std::size_t i = 0; i < present_.u.size(); i += 3)
    largest = std::max(
        largest, static_cast<double>(present_.u[i] * present_.u[i] + present_.u[i + 1] * present_.u[i + 1] +
                                     present_.u[i + 2] * present_.u[i + 2]));
  record.largest = std::sqrt(largest);
  if (each_) each_(record, present_.u);
  records_.push_back(std::move(record));
}

void ShapeLog::displacements(const ShapeRecord& record, std::vector<float>& u) const {
  const Eigen::Vector3f g = record.slope.cast<float>();
  u.resize(3 * nodes_.size());
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] = slope_[3 * i] * g[0] + slope_[3 * i + 1] * g[1] + slope_[3 * i + 2] * g[2];
  for (std::size_t k = 0; k < record.states.size(); ++k) {
    const std::vector<double>& moved = *known_.moved[record.states[k]];
    const float w = record.weights[k];
    for (std::size_t v = 0; v < nodes_.size(); ++v)
      for (std::size_t c = 0; c < 3; ++c)
        u[3 * v + c] += w * static_cast<float>(moved[3 * static_cast<std::size_t>(nodes_[v]) + c]);
  }
}

std::string shapes_ended(const ShapeLog& log, const std::exception& problem) {
  return fmt::format("shapes ended after {:.4g} s: {}", log.records().empty() ? 0.0 : log.records().back().t,
                     problem.what());
}

void check_shapeable(std::span<const State> states, const Body& body, const std::string& name) {
  std::size_t usable = 0, without = 0, other = 0;
  for (const State& state : states) {
    if (!state.usable()) continue;
    ++usable;
    if (is_shapeable(state, body)) continue;
    ++(state.displacements ? other : without);
  }
  if (without > 0)
    throw InputError(
        {.file = name},
        fmt::format("{} of {} states hold no displacements, which shapes (session.shape_rate) are made "
                    "of; expected states solved with state_space.displacements = true",
                    without, usable));
  if (other > 0)
    throw InputError(
        {.file = name},
        fmt::format("{} of {} states hold displacements of another mesh, expected those of {} nodes", other,
                    usable, body.mesh.nodes.size()));
}

}  // namespace forefeel
