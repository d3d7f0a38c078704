#include "scheduling/shape/shape_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/common/error.hpp"
#include "scheduling/common/option_check.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

void check(const ShapeOptions& options) {
  using detail::expect_option;
  expect_option(std::isfinite(options.rate) && options.rate >= 0 && options.rate <= 200, "shape_rate",
                fmt::format("is {}, expected 0 to 200 Hz", options.rate));
  expect_option(options.checks <= 10'000, "shape_checks",
                fmt::format("is {}, expected 0 to 10000", options.checks));
  expect_option(options.neighbours >= 1 && options.neighbours <= 200, "shape_neighbours",
                fmt::format("is {}, expected 1 to 200", options.neighbours));
}

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

ShapeLog::ShapeLog(std::shared_ptr<const Body> body, const ShapeOptions& options, EachShape each,
                   std::shared_ptr<const RestSites> sites)
    : body_(std::move(body)), options_(options), each_(std::move(each)), sites_(std::move(sites)) {
  check(options_);
  if (options_.surface) {
    nodes_ = surface_nodes(body_->mesh);
  } else {
    nodes_.resize(body_->mesh.nodes.size());
    std::iota(nodes_.begin(), nodes_.end(), NodeIndex{0});
  }
  if (sites_)
    jets_ = std::make_unique<SiteJets>(*sites_);
  else
    slope_ = slope_at_rest(body_, nodes_);
}

std::vector<float> ShapeLog::slope_at(const SurfacePlace& site) const {
  std::vector<double> tangent;
  {
    const std::lock_guard lock(busy_);
    tangent = jets_->tangent(site);
  }
  std::vector<float> slope;
  slope.reserve(9 * nodes_.size());
  for (const NodeIndex node : nodes_)
    for (std::size_t k = 0; k < 9; ++k)
      slope.push_back(static_cast<float>(tangent[9 * static_cast<std::size_t>(node) + k]));
  return slope;
}

void ShapeLog::add_slope(std::span<const float> slope, const Vec3& g, std::vector<float>& u) const {
  const Eigen::Vector3f by = g.cast<float>();
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] += slope[3 * i] * by[0] + slope[3 * i + 1] * by[1] + slope[3 * i + 2] * by[2];
}

void ShapeLog::learn(const State& state) {
  check_shapeable({&state, 1}, *body_, "a solved state");
  known_.at.push_back(state.at);
  known_.moved.push_back(state.displacements);
  if (!sites_) return;
  known_.site.push_back(state.site);
  std::vector<float>& curved = known_.curved.emplace_back(3 * nodes_.size(), 0.0f);
  if (state.at.isZero(0)) return;
  add_slope(slope_at(sites_->map().nearest(state.site)), -state.at, curved);
  for (std::size_t v = 0; v < nodes_.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c)
      curved[3 * v + c] +=
          static_cast<float>((*state.displacements)[3 * static_cast<std::size_t>(nodes_[v]) + c]);
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

void ShapeLog::weigh(const Vec3& at, ShapeRecord& record) const {
  const ShapeWeights weights = shape_weights(at, present_.places);
  record.slope = weights.of_slope;
  record.order = weights.order;
  for (std::size_t i = 0; i < present_.near.size(); ++i) {
    if (weights.of_states[i] == 0) continue;
    record.states.push_back(present_.near[i]);
    record.weights.push_back(static_cast<float>(weights.of_states[i]));
  }
}

void ShapeLog::weigh_touch(const Vec3& x, ShapeRecord& record) const {
  constexpr double least = 1e-9, farthest_ratio = 2;  // [m], [1]
  const double reach = 2 * sites_->body().pad->radius;
  record.slope = x;
  double nearest = reach, sum = 0;
  std::vector<double> weights;
  for (std::uint32_t id = 0; id < known_.at.size(); ++id) {
    if (known_.at[id].norm() < least) continue;
    const double d = std::hypot((known_.at[id] - x).norm(), (known_.site[id] - record.site.at).norm());
    if (d >= reach) continue;
    nearest = std::min(nearest, d);
    const double weight = std::pow(1 / std::max(d, least) - 1 / reach, 2);
    sum += weight;
    record.states.push_back(id);
    weights.push_back(weight * std::pow(std::min(x.norm() / known_.at[id].norm(), farthest_ratio), 2));
  }
  for (const double weight : weights)
    record.weights.push_back(static_cast<float>((1 - nearest / reach) * weight / sum));
}

void ShapeLog::take(double t, const Vec3& at, const SurfacePlace& site) {
  ShapeRecord record{.t = t,
                     .at = at,
                     .site = site,
                     .known = static_cast<std::uint32_t>(known_.at.size()),
                     .states = {},
                     .weights = {}};
  if (!sites_) {
    choose_near(at);
    weigh(at, record);
  } else if (site.exists()) {
    weigh_touch(at - site.at, record);
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
  u.assign(3 * nodes_.size(), 0.0f);
  if (!sites_)
    add_slope(slope_, record.slope, u);
  else if (record.site.exists())
    add_slope(slope_at(record.site), record.slope, u);
  for (std::size_t k = 0; k < record.states.size(); ++k) {
    const float w = record.weights[k];
    if (sites_) {
      const std::vector<float>& curved = known_.curved[record.states[k]];
      for (std::size_t i = 0; i < u.size(); ++i) u[i] += w * curved[i];
      continue;
    }
    const std::vector<double>& moved = *known_.moved[record.states[k]];
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
