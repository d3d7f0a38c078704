#include "solver/solver.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "solver/newton.hpp"

namespace forefeel {
namespace {

using SteadyClock = std::chrono::steady_clock;

double seconds_since(SteadyClock::time_point start) {
  return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

constexpr double smallest_share = 1.0 / 256;   // of a continuation step, after halvings

}  // namespace

struct Solver::Impl {
  std::shared_ptr<const Body> body;
  std::shared_ptr<const Discretisation> d;
  NewtonSolver newton;
  std::vector<double> u, trial, tangent;        // local; tangent is local size x 3
  Vec3 at = Vec3::Zero();
  bool has_tangent = false;
  int iterations = 0;

  explicit Impl(std::shared_ptr<const Body> b)
      : body(std::move(b)), d(std::make_shared<const Discretisation>(discretise(*body))), newton(d) {
    u.resize(static_cast<std::size_t>(d->local_size()));
    tangent.resize(3 * u.size());
  }

  void begin_at_rest() {
    std::fill(u.begin(), u.end(), 0.0);
    at = Vec3::Zero();
    has_tangent = false;
    iterations = 0;
  }

  void begin_at(const Equilibrium& start) {
    d->to_local(start.displacements, u.data());
    at = start.at;
    iterations = 0;
    has_tangent = !start.tangent.empty();
    if (!has_tangent) return;
    const auto clamp = static_cast<std::int32_t>(d->free_nodes + 1);
    std::fill(tangent.begin(), tangent.end(), 0.0);
    for (std::size_t node = 0; node < d->local.size(); ++node)
      if (d->local[node] != clamp)
        std::copy_n(&start.tangent[9 * node], 9, &tangent[9 * static_cast<std::size_t>(d->local[node])]);
  }

  bool take_tangent() {
    if (has_tangent) return true;
    if (!newton.factorise(u)) return false;
    newton.factor().tangent(tangent.data());
    return has_tangent = true;
  }

  // Contact from `at` to x in one go: the tangent predicts, Newton corrects. On failure u stays where it was.
  NewtonReport step_to(const Vec3& x, double tolerance, int max_iterations, const std::stop_token& stop) {
    NewtonReport report;
    if (!take_tangent()) {
      report.status = SolveStatus::diverged;
      return report;
    }
    const Vec3 move = x - at;
    trial = u;
    for (std::size_t i = 0; i < trial.size(); ++i)
      trial[i] += tangent[3 * i] * move[0] + tangent[3 * i + 1] * move[1] + tangent[3 * i + 2] * move[2];
    for (int i = 0; i < 3; ++i) trial[static_cast<std::size_t>(3 * d->free_nodes + i)] = x[i];
    report = newton.solve(trial, tolerance, max_iterations, stop);
    iterations += report.iterations;
    if (report.status != SolveStatus::converged) return report;
    std::swap(u, trial);
    at = x;
    newton.factor().tangent(tangent.data());
    return report;
  }

  // Straight from `at` to x in steps of at most max_step, each halved where it fails.
  NewtonReport advance(const Vec3& x, double max_step, double tolerance, int max_iterations,
                       const std::stop_token& stop) {
    const Vec3 from = at;
    const double distance = (x - from).norm();
    const double steps = max_step > 0 ? std::max(1.0, std::ceil(distance / max_step * (1 - 1e-12))) : 1.0;
    double done = 0, share = 1 / steps;
    const double least = smallest_share * share;
    NewtonReport report;
    do {
      const double next = done + share >= 1 - 1e-9 ? 1.0 : done + share;
      const Vec3 target = next == 1.0 ? x : Vec3(from + next * (x - from));
      report = step_to(target, tolerance, max_iterations, stop);
      if (report.status == SolveStatus::converged) {
        done = next;
        share = std::min(1 / steps, 2 * share);
      } else if (report.status == SolveStatus::cancelled || share <= least) {
        break;
      } else {
        share *= 0.5;
      }
    } while (done < 1);
    return report;
  }

  SolveOutcome outcome(const NewtonReport& report, const Vec3& x, const Vec3& parent, double seconds,
                       const SolveOptions& options) {
    SolveOutcome out;
    State& s = out.state;
    s.at = x;
    s.parent = parent;
    s.status = report.status;
    s.iterations = iterations;
    s.seconds = seconds;
    s.residual = report.residual;
    s.min_jacobian = report.min_jacobian;
    if (report.status != SolveStatus::converged) {
      out.warnings.push_back(fmt::format("not converged: {}, held at {:.4g} of {:.4g} m", name(report.status),
                                         (at - parent).norm(), (x - parent).norm()));
      return out;
    }
    s.force = report.force;
    s.energy = report.energy;
    s.stiffness = newton.factor().stiffness();
    if (report.min_jacobian <= 0) out.warnings.push_back("some elements are inverted: det F <= 0");
    auto equilibrium = std::make_shared<Equilibrium>();
    equilibrium->at = x;
    equilibrium->displacements = d->to_nodes(u.data());
    equilibrium->tangent.resize(9 * d->local.size());
    for (std::size_t node = 0; node < d->local.size(); ++node)
      std::copy_n(&tangent[9 * static_cast<std::size_t>(d->local[node])], 9, &equilibrium->tangent[9 * node]);
    if (options.want_displacements)
      s.displacements = std::make_shared<const std::vector<double>>(
          equilibrium->displacements.begin(),
          equilibrium->displacements.begin() + static_cast<std::ptrdiff_t>(3 * body->mesh.nodes.size()));
    out.equilibrium = std::move(equilibrium);
    return out;
  }
};

Solver::Solver(std::shared_ptr<const Body> body) : impl_(std::make_unique<Impl>(std::move(body))) {}
Solver::~Solver() = default;
Solver::Solver(Solver&&) noexcept = default;
Solver& Solver::operator=(Solver&&) noexcept = default;

const Body& Solver::body() const { return *impl_->body; }

std::shared_ptr<const Equilibrium> Solver::rest() const {
  auto rest = std::make_shared<Equilibrium>();
  rest->displacements.assign(3 * static_cast<std::size_t>(impl_->d->nodes), 0.0);
  return rest;
}

SolveOutcome Solver::reference(const Vec3& x, double spacing, const SolveOptions& options) {
  const auto start = SteadyClock::now();
  impl_->begin_at_rest();
  const NewtonReport report = impl_->advance(x, spacing, options.tolerance, options.max_iterations, {});
  return impl_->outcome(report, x, Vec3::Zero(), seconds_since(start), options);
}

SolveOutcome Solver::from(const Equilibrium& start, const Vec3& x, const SolveOptions& options, std::stop_token stop) {
  const auto begun = SteadyClock::now();
  impl_->begin_at(start);
  const NewtonReport report =
      impl_->advance(x, options.max_step, options.tolerance, options.max_iterations, stop);
  return impl_->outcome(report, x, start.at, seconds_since(begun), options);
}

}  // namespace forefeel
