#include "solver/equilibrium/continuation.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {
namespace {

constexpr double smallest_share = 1.0 / 256;  // of a continuation step, after halvings
constexpr double most_steps = 5000;

}  // namespace

void detail::predict(const LocalField& field, const Vec3& move, const Vec3& x, std::vector<double>& u) {
  u.resize(field.u.size());
  const double *va = field.tangent.data(), *vb = va + u.size(), *vc = vb + u.size();
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] = field.u[i] + va[i] * move[0] + vb[i] * move[1] + vc[i] * move[2];
  std::copy_n(x.data(), 3, u.end() - 6);  // the contact; the clamp is last
}

Continuation::Continuation(std::shared_ptr<const Discretisation> discretisation, Precision precision)
    : d_(std::move(discretisation)), newton_(d_, precision) {
  field_.u.resize(static_cast<std::size_t>(d_->local_size()));
  field_.tangent.resize(3 * field_.u.size());
}

void Continuation::begin_at_rest() {
  std::fill(field_.u.begin(), field_.u.end(), 0.0);
  at_ = Vec3::Zero();
  has_tangent_ = has_factor_ = false;
  iterations_ = 0;
  kinks_ = {};
}

void Continuation::begin_at(const Vec3& at, const LocalField& field) {
  has_factor_ = has_factor_ && at_ == at && field_.u == field.u;  // reused if the last solve ended here
  field_.u = field.u;
  has_tangent_ = !field.tangent.empty();
  if (has_tangent_) field_.tangent = field.tangent;
  at_ = at;
  iterations_ = 0;
  kinks_ = {};
}

bool Continuation::take_tangent() {
  if (has_tangent_) return true;
  if (!newton_.factorise(field_.u)) return has_factor_ = false;
  newton_.factor().tangent(field_.tangent.data());
  return has_tangent_ = has_factor_ = true;
}

bool Continuation::prepare() {
  if (!take_tangent()) return false;
  return has_factor_ = has_factor_ || newton_.factorise(field_.u);
}

NewtonReport Continuation::step_to(const Vec3& x, double tolerance, int max_iterations,
                                   const std::stop_token& stop, bool keep_factor) {
  NewtonReport report;
  const Vec3 move = x - at_;
  if (move.isZero(0) && !has_tangent_) {  // resumes an interrupted iteration
    trial_ = field_.u;
    return correct_trial(x, tolerance, max_iterations, stop, keep_factor);
  }
  if (!take_tangent()) {
    report.status = SolveStatus::diverged;
    return report;
  }
  detail::predict(field_, move, x, trial_);
  detail::predict(field_, 0.5 * move, 0.5 * (x + at_), half_);
  report = correct_trial(x, tolerance, max_iterations, stop, keep_factor);
  if (report.status != SolveStatus::converged) return report;
  // half_ + V_b move / 2 - u_b
  const std::size_t size = field_.u.size(), rows = static_cast<std::size_t>(3 * d_->free_nodes);
  const double *va = field_.tangent.data(), *vb = va + size, *vc = vb + size;
  double largest = 0;
  for (std::size_t i = 0; i < rows; ++i)
    largest = std::max(
        largest,
        std::abs(half_[i] + 0.5 * (va[i] * move[0] + vb[i] * move[1] + vc[i] * move[2]) - field_.u[i]));
  if (move.norm() > 0) kinks_ = {largest / move.norm(), kinks_[0]};
  return report;
}

NewtonReport Continuation::correct(const std::vector<double>& u, const Vec3& x, double tolerance,
                                   int max_iterations, const std::stop_token& stop) {
  trial_ = u;
  iterations_ = 0;
  return correct_trial(x, tolerance, max_iterations, stop, true);
}

NewtonReport Continuation::correct_trial(const Vec3& x, double tolerance, int max_iterations,
                                         const std::stop_token& stop, bool keep_factor) {
  has_factor_ = false;
  NewtonReport report = newton_.solve(trial_, tolerance, max_iterations, stop, keep_factor);
  iterations_ += report.iterations;
  if (report.status != SolveStatus::converged) return report;
  if (!newton_.condense(trial_, newton_.contraction(), field_.tangent.data(), stiffness_)) {
    has_tangent_ = false;
    // an equilibrium, but not a stable one, or no factor fits it
    if (!newton_.factorise(trial_) || !newton_.condense(trial_, 0, field_.tangent.data(), stiffness_)) {
      report.status = SolveStatus::diverged;
      return report;
    }
  }
  std::swap(field_.u, trial_);
  at_ = x;
  has_tangent_ = has_factor_ = true;
  return report;
}

NewtonReport Continuation::advance(const Vec3& x, double max_step, double tolerance, int max_iterations,
                                   const std::stop_token& stop, double between) {
  const Vec3 from = at_;
  const double distance = (x - from).norm();
  const double steps = max_step > 0 ? std::max(1.0, std::ceil(distance / max_step * (1 - 1e-12))) : 1.0;
  if (!(steps <= most_steps)) {  // not finite, or given in other units than metres
    NewtonReport report;
    report.status = SolveStatus::stalled;
    return report;
  }
  double done = 0, share = 1 / steps;
  const double least = smallest_share * share;
  NewtonReport report;
  do {
    const double next = done + share >= 1 - 1e-9 ? 1.0 : done + share;
    const Vec3 target = next == 1.0 ? x : Vec3(from + next * (x - from));
    report =
        step_to(target, between > 0 && next < 1 ? between : tolerance, max_iterations, stop, between > 0);
    if (report.status == SolveStatus::converged) {
      done = next;
      share = std::min(1 / steps, 2 * share);
      if (progress_) progress_(done);
    } else if (report.status == SolveStatus::cancelled || share <= least) {
      break;
    } else {
      share *= 0.5;
    }
  } while (done < 1);
  return report;
}

}  // namespace forefeel
