#include "solver/equilibrium/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "solver/equilibrium/continuation.hpp"
#include "solver/equilibrium/linear_body.hpp"
#include "solver/equilibrium/state_jets.hpp"

namespace forefeel {
namespace {

using SteadyClock = std::chrono::steady_clock;

double seconds_since(SteadyClock::time_point start) {
  return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

// A jet needs the equilibrium and its own factor.
SolveOptions exact_for_jet(SolveOptions options) {
  if (options.jet > 1) {
    options.tolerance = std::min(options.tolerance, jet_tolerance);
    options.keep_factor = false;
  }
  return options;
}

}  // namespace

struct Solver::Impl {
  std::shared_ptr<const Body> body;
  std::shared_ptr<const Discretisation> d;
  Continuation path;
  LaneSolver lanes;
  StateJets jets;
  std::unique_ptr<LinearBody> linear;  // made at the first solve of a linear body

  Impl(std::shared_ptr<const Body> b, std::shared_ptr<const Discretisation> shared)
      : body(std::move(b)), d(std::move(shared)), path(d), lanes(d), jets(d) {}

  void begin_at(const Equilibrium& start) {
    LocalField field;
    field.u.resize(static_cast<std::size_t>(d->local_size()));
    d->to_local(start.displacements, field.u.data());
    const auto tip = static_cast<std::size_t>(3 * d->free_nodes);  // no node of the mesh behind a pad
    std::copy_n(start.at.data(), 3, &field.u[tip]);
    if (!start.tangent.empty()) {
      field.tangent.assign(3 * field.u.size(), 0.0);
      const auto clamp = static_cast<std::int32_t>(d->free_nodes + 1);
      for (std::size_t node = 0; node < d->local.size(); ++node)
        if (d->local[node] != clamp)
          for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t c = 0; c < 3; ++c)
              field.tangent[c * field.u.size() + 3 * static_cast<std::size_t>(d->local[node]) + i] =
                  start.tangent[9 * node + 3 * i + c];
      for (std::size_t c = 0; c < 3; ++c) field.tangent[c * field.u.size() + tip + c] = 1;
    }
    path.begin_at(start.at, field);
  }

  void keep(const LocalField& field, const SolveOptions& options, SolveOutcome& out) const {
    auto equilibrium = std::make_shared<Equilibrium>();
    equilibrium->at = out.state.at;
    equilibrium->displacements = d->to_nodes(field.u.data());
    equilibrium->tangent.resize(9 * d->local.size());
    for (std::size_t node = 0; node < d->local.size(); ++node)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t c = 0; c < 3; ++c)
          equilibrium->tangent[9 * node + 3 * i + c] =
              field.tangent[c * field.u.size() + 3 * static_cast<std::size_t>(d->local[node]) + i];
    if (options.want_displacements)
      out.state.displacements = std::make_shared<const std::vector<double>>(
          equilibrium->displacements.begin(),
          equilibrium->displacements.begin() + static_cast<std::ptrdiff_t>(3 * body->mesh.nodes.size()));
    out.equilibrium = std::move(equilibrium);
    if (out.state.solve.min_jacobian <= 0) out.warnings.push_back("some elements are inverted: det F <= 0");
  }

  void keep_partial(SolveOutcome& out) const {
    auto partial = std::make_shared<Equilibrium>();
    const std::vector<double>& u = path.trial();
    const auto contact = static_cast<std::size_t>(3 * d->free_nodes);
    partial->at = {u[contact], u[contact + 1], u[contact + 2]};
    partial->displacements = d->to_nodes(u.data());
    out.partial = std::move(partial);
  }

  // Solves up to eight states in lanes; false for each state that was not solved.
  std::array<bool, lane_count> run_lanes(const Vec3* xs, std::size_t count, const SolveOptions& options,
                                         SolveOutcome* out) {
    std::array<LocalField, lane_count> fields;
    std::vector<LocalField*> pointers;
    for (std::size_t i = 0; i < count; ++i) {
      detail::predict(path.field(), xs[i] - path.at(), xs[i], fields[i].u);
      fields[i].tangent = path.field().tangent;
      pointers.push_back(&fields[i]);
    }
    std::array<LaneResult, lane_count> results;
    lanes.solve(path.newton().factor(), pointers, options.tolerance, results);
    std::array<bool, lane_count> done{};
    for (std::size_t i = 0; i < count; ++i) {
      LaneResult& result = results[i];
      done[i] = result.converged && result.min_jacobian > 0;
      if (done[i] && !result.stiffness_settled) {
        path.forget_factor();
        done[i] = detail::condense_alone(path.newton(), fields[i], result);
      }
      if (!done[i]) continue;
      State& s = out[i].state;
      s.at = xs[i];
      s.solve.parent = path.at();
      detail::copy_result(result, s);
      keep(fields[i], options, out[i]);
      if (options.jet > 1) s.jet = jets.near(fields[i].u, options.jet);
    }
    return done;
  }

  // True if the trapezium rule on the stiffnesses leads from one force to the other: both lie on one branch.
  bool fits(const State& a, const State& b) const {
    const Vec3 predicted = a.force - 0.5 * (a.stiffness + b.stiffness) * (b.at - a.at);
    return (predicted - b.force).norm() <= 0.1 * std::max({a.force.norm(), b.force.norm(), d->force_floor});
  }

  SolveOutcome outcome(const NewtonReport& report, const Vec3& x, const Vec3& parent,
                       const SolveOptions& options) {
    SolveOutcome out;
    State& s = out.state;
    s.at = x;
    s.solve.parent = parent;
    s.solve.status = report.status;
    s.solve.iterations = path.iterations();
    s.solve.residual = report.residual;
    s.solve.min_jacobian = report.min_jacobian;
    if (report.status != SolveStatus::converged) {
      out.warnings.push_back(fmt::format("not converged: {}, held at {:.4g} of {:.4g} m", name(report.status),
                                         (path.at() - parent).norm(), (x - parent).norm()));
      if (report.status == SolveStatus::cancelled && path.iterations() > 0) keep_partial(out);
      return out;
    }
    s.force = report.force;
    s.energy = report.energy;
    s.stiffness = path.stiffness();
    keep(path.field(), options, out);
    if (options.jet > 1) s.jet = jets.at(path.field(), path.newton().factor(), options.jet);
    return out;
  }

  SolveOutcome linear_outcome(const Vec3& x, const Vec3& parent, const SolveOptions& options) {
    if (!linear) linear = std::make_unique<LinearBody>(*d, path.newton());
    SolveOutcome out;
    LocalField field;
    out.state = linear->state(x, field);
    out.state.solve.parent = parent;
    if (out.state.usable()) keep(field, options, out);
    if (out.state.usable() && options.jet > 1)
      out.state.jet = std::make_shared<const EnergyJet>(EnergyJet{.order = options.jet});
    return out;
  }
};

SolverBasis::SolverBasis(std::shared_ptr<const Body> body) : body_(std::move(body)) {}

std::shared_ptr<const Discretisation> SolverBasis::discretisation() {
  std::call_once(once_, [this] { discretisation_ = analyse(*body_); });
  return discretisation_;
}

// Sums up the factor, the blocks of H now and at rest, the vectors of Newton and continuation, and vectors in lanes.
std::size_t SolverBasis::bytes_per_solver(int jet) {
  const std::shared_ptr<const Discretisation> d = discretisation();
  const FactorCost factor = cost_of_factor(*d);
  const std::int64_t blocks = 2 * 9 * (d->pattern.size() + 1);
  constexpr std::int64_t alone = 16, in_lanes = 21 + 8;  // vectors; of a batch's fields too
  const std::int64_t of_factor = factor.factor_bytes + factor.stack_bytes;
  std::int64_t bytes = of_factor + 8 * (blocks + (alone + in_lanes * lane_count) * d->local_size());
  if (jet > 1)  // StateJets has a factor of its own, and two vectors in lanes
    bytes += of_factor + 8 * (blocks + (alone + 2 * lane_count) * d->local_size());
  return static_cast<std::size_t>(bytes);
}

Solver::Solver(std::shared_ptr<const Body> body) {
  const std::shared_ptr<const Discretisation> d = analyse(*body);
  impl_ = std::make_unique<Impl>(std::move(body), d);
}
Solver::Solver(Body body) : Solver(std::make_shared<const Body>(std::move(body))) {}
Solver::Solver(SolverBasis& basis) : impl_(std::make_unique<Impl>(basis.body(), basis.discretisation())) {}
Solver::~Solver() = default;
Solver::Solver(Solver&&) noexcept = default;
Solver& Solver::operator=(Solver&&) noexcept = default;

const Body& Solver::body() const {
  return *impl_->body;
}

void Solver::watch(std::function<void(double)> progress) {
  impl_->path.watch(std::move(progress));
}

std::shared_ptr<const Equilibrium> Solver::rest() const {
  auto rest = std::make_shared<Equilibrium>();
  rest->displacements.assign(3 * static_cast<std::size_t>(impl_->d->nodes), 0.0);
  return rest;
}

SolveOutcome Solver::reference(const Vec3& x, double spacing, const SolveOptions& wanted) {
  const SolveOptions options = exact_for_jet(wanted);
  const auto start = SteadyClock::now();
  SolveOutcome out;
  if (is_linear(*impl_->body)) {
    out = impl_->linear_outcome(x, Vec3::Zero(), options);
  } else {
    impl_->path.begin_at_rest();
    const NewtonReport report =
        impl_->path.advance(x, spacing, options.tolerance, options.max_iterations, {});
    out = impl_->outcome(report, x, Vec3::Zero(), options);
  }
  out.state.solve.seconds = seconds_since(start);
  return out;
}

bool second_way_differs(Solver& solver, const State& state, double spacing, const SolveOptions& options) {
  if (state.solve.status != SolveStatus::converged || is_linear(solver.body())) return false;
  std::array<int, 3> axes{0, 1, 2};  // the longest part last
  std::stable_sort(axes.begin(), axes.end(),
                   [&](int a, int b) { return std::abs(state.at[a]) < std::abs(state.at[b]); });
  SolveOptions leg = options;
  leg.max_step = spacing;
  leg.want_displacements = false;
  std::shared_ptr<const Equilibrium> at = solver.rest();
  Vec3 target = Vec3::Zero(), force = state.force;
  for (const int axis : axes) {
    if (state.at[axis] == 0) continue;
    target[axis] = state.at[axis];
    const SolveOutcome outcome = solver.from(*at, target, leg);
    if (!outcome.equilibrium) return false;
    at = outcome.equilibrium;
    force = outcome.state.force;
  }
  return (force - state.force).norm() > 1e-4 * std::max(force.norm(), state.force.norm());
}

SolveOutcome Solver::from(const Equilibrium& start, const Vec3& x, const SolveOptions& wanted,
                          std::stop_token stop) {
  const SolveOptions options = exact_for_jet(wanted);
  const auto begun = SteadyClock::now();
  SolveOutcome out;
  if (is_linear(*impl_->body)) {
    out = impl_->linear_outcome(x, start.at, options);
  } else {
    impl_->begin_at(start);
    const NewtonReport report =
        impl_->path.advance(x, options.max_step, options.tolerance, options.max_iterations, stop,
                            options.keep_factor ? options.tolerance : 0);
    out = impl_->outcome(report, x, start.at, options);
  }
  out.state.solve.seconds = seconds_since(begun);
  return out;
}

std::vector<SolveOutcome> Solver::beside(const Equilibrium& near, const std::vector<Vec3>& xs,
                                         const SolveOptions& options, std::stop_token stop) {
  std::vector<SolveOutcome> out(xs.size());
  std::vector<bool> done(xs.size(), false);
  const auto begun = SteadyClock::now();
  if (!is_linear(*impl_->body)) {
    impl_->begin_at(near);
    const bool ready = impl_->path.prepare();
    for (std::size_t first = 0; ready && first < xs.size() && !stop.stop_requested(); first += lane_count) {
      const std::size_t count = std::min<std::size_t>(lane_count, xs.size() - first);
      const auto solved = impl_->run_lanes(&xs[first], count, options, &out[first]);
      for (std::size_t i = 0; i < count; ++i) done[first + i] = solved[i];
    }
    std::size_t solved = 0;
    for (std::size_t i = 0; i < xs.size(); ++i) {
      for (std::size_t k = 0; k < xs.size() && done[i]; ++k)
        if (k != i && done[k]) done[i] = impl_->fits(out[k].state, out[i].state);
      solved += done[i];
    }
    for (std::size_t i = 0; i < xs.size(); ++i)
      if (done[i]) out[i].state.solve.seconds = seconds_since(begun) / static_cast<double>(solved);
  }
  for (std::size_t i = 0; i < xs.size(); ++i)
    if (!done[i]) out[i] = from(near, xs[i], options, stop);
  return out;
}

}  // namespace forefeel
