#include "solver/equilibrium/newton.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {
namespace {

double norm(const double* v, std::int64_t size) {
  double sum = 0;
  for (std::int64_t i = 0; i < size; ++i) sum += v[i] * v[i];
  return std::sqrt(sum);
}

}  // namespace

NewtonSolver::NewtonSolver(std::shared_ptr<const Discretisation> discretisation, Precision precision)
    : d_(std::move(discretisation)), factor_(*d_, precision) {
  const auto size = static_cast<std::size_t>(d_->local_size());
  gradient_.resize(size);
  trial_gradient_.resize(size);
  step_.resize(size);
  trial_.resize(size);
  blocks_.resize(9 * static_cast<std::size_t>(d_->pattern.size() + 1));
}

void NewtonSolver::evaluate(const std::vector<double>& u, NewtonReport& report) {
  std::fill(trial_gradient_.begin(), trial_gradient_.end(), 0.0);
  const FieldSummary field = d_->elements.gradient(u.data(), trial_gradient_.data());
  report.energy = field.energy;
  report.min_jacobian = field.min_jacobian;
  const double* contact = trial_gradient_.data() + 3 * d_->free_nodes;
  report.force = -Vec3(contact[0], contact[1], contact[2]);
  report.residual =
      norm(trial_gradient_.data(), 3 * d_->free_nodes) / std::max(report.force.norm(), d_->force_floor);
}

bool NewtonSolver::factorise(const std::vector<double>& u) {
  std::fill(blocks_.begin(), blocks_.end(), 0.0);
  d_->elements.hessian(u.data(), blocks_.data());
  return factor_.compute(blocks_.data());
}

bool NewtonSolver::factorise_shifted(const std::vector<double>& u) {
  shift_ = 0;
  if (factorise(u)) return true;
  if (rest_blocks_.empty()) {
    rest_blocks_.assign(blocks_.size(), 0.0);
    const std::vector<double> rest(u.size(), 0.0);
    d_->elements.hessian(rest.data(), rest_blocks_.data());
  }
  for (const double wanted : {0.05, 0.2, 0.8, 3.2, 12.8, 51.2}) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) blocks_[i] += (wanted - shift_) * rest_blocks_[i];
    shift_ = wanted;
    if (factor_.compute(blocks_.data())) return true;
  }
  return false;
}

// Moves u along step_, a direction of descent. False if no length of the step helps.
bool NewtonSolver::line_search(std::vector<double>& u, NewtonReport& report) {
  const auto rows = static_cast<std::size_t>(3 * d_->free_nodes);
  double slope = 0;
  for (std::size_t i = 0; i < rows; ++i) slope += gradient_[i] * step_[i];
  double length = 1;
  for (int halvings = 0; halvings < 30; ++halvings, length *= 0.5) {
    trial_ = u;
    for (std::size_t i = 0; i < rows; ++i) trial_[i] += length * step_[i];
    NewtonReport next;
    evaluate(trial_, next);
    const bool finite = std::isfinite(next.energy) && std::isfinite(next.residual);
    const bool lower = next.energy <= report.energy + 1e-4 * length * slope;
    const bool closer = shift_ == 0 && next.residual < (1 - 0.1 * length) * report.residual;
    if (!finite || !(lower || closer)) continue;
    next.iterations = report.iterations;
    report = next;
    std::swap(u, trial_);
    std::swap(gradient_, trial_gradient_);
    return true;
  }
  return false;
}

NewtonReport NewtonSolver::solve(std::vector<double>& u, double tolerance, int max_iterations,
                                 const std::stop_token& stop, bool keep_factor) {
  NewtonReport report;
  contraction_ = 0;
  evaluate(u, report);
  std::swap(gradient_, trial_gradient_);
  if (!std::isfinite(report.energy) || !std::isfinite(report.residual)) {
    report.status = report.min_jacobian > 0 ? SolveStatus::diverged : SolveStatus::inverted;
    return report;
  }
  const std::int64_t n = 3 * d_->free_nodes;
  bool has_factor = false;
  double before = 0;  // the residual before the last step
  while (true) {
    if (stop.stop_requested()) {
      report.status = SolveStatus::cancelled;
      return report;
    }
    // A factor is reused while each step with it reduces the residual fivefold: a step without a new factor
    // costs a tenth. The equilibrium itself gets its own factor, which also shows that it is stable, unless
    // keep_factor is set.
    const bool settled = report.residual <= tolerance ||
                         report.residual * std::max(report.force.norm(), d_->force_floor) <= d_->round_off;
    const bool keep = has_factor && (keep_factor || !settled) && report.residual < 0.2 * before;
    contraction_ = keep ? std::max(contraction_, report.residual / before) : 0;
    has_factor = keep || factorise_shifted(u);
    before = report.residual;
    if (!has_factor) {
      report.status = SolveStatus::diverged;
      return report;
    }
    if (settled && shift_ == 0) {
      report.status = SolveStatus::converged;
      return report;
    }
    if (report.iterations >= max_iterations) {
      report.status = SolveStatus::stalled;
      return report;
    }
    ++report.iterations;
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) step_[i] = -gradient_[i];
    factor_.solve(step_.data());
    const double moved = norm(step_.data(), n), all = norm(u.data(), n + 3);
    const bool fresh = !keep;
    if (line_search(u, report)) {
      has_factor = shift_ == 0;
      continue;
    }
    if (!fresh) {
      has_factor = false;
      continue;
    }
    const bool round_off = shift_ == 0 && moved <= 1e-11 * all && report.residual <= 1e-7;
    report.status = round_off                 ? SolveStatus::converged
                    : report.min_jacobian > 0 ? SolveStatus::stalled
                                              : SolveStatus::inverted;
    return report;
  }
}

bool NewtonSolver::condense(const std::vector<double>& u, double left, double* tangent, Mat3& stiffness) {
  factor_.tangent(tangent);
  stiffness = factor_.stiffness();
  if (left == 0 && factor_.precision() == Precision::exact) return true;
  constexpr double settled_share = 1e-5, largest_gain = 1e-3;  // as in lane_solver.cpp
  const int most_rounds = left > 0 ? 3 : 12;  // beyond three a new factor is cheaper, unless this one is new
  const std::size_t size = u.size(), rows = static_cast<std::size_t>(3 * d_->free_nodes);
  product_.resize(3 * size);
  lanes_.resize(size * lane_count);
  for (int round = 0; round < most_rounds; ++round) {
    std::fill(product_.begin(), product_.end(), 0.0);
    d_->elements.product(static_cast<std::int64_t>(size), u.data(), tangent, product_.data());
    std::fill(lanes_.begin(), lanes_.end(), 0.0);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < rows; ++i) lanes_[i * lane_count + c] = -product_[c * size + i];
    factor_.solve_lanes(lanes_.data());
    Mat3 plain, gain;
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = a; b < 3; ++b) {
        double sum = product_[b * size + rows + a], lost = 0;
        for (std::size_t i = 0; i < rows; ++i) {
          sum += tangent[a * size + i] * product_[b * size + i];
          lost -= product_[a * size + i] * lanes_[i * lane_count + b];
        }
        const auto row = static_cast<int>(a), column = static_cast<int>(b);
        plain(row, column) = plain(column, row) = sum;
        gain(row, column) = gain(column, row) = lost;
      }
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < rows; ++i) tangent[c * size + i] += lanes_[i * lane_count + c];
    stiffness = plain - gain;
    const double share = gain.norm() / stiffness.norm();
    if (share <= largest_gain && std::max(left, 0.03) * share <= settled_share) return true;
  }
  return false;
}

Precision fitting_precision(const std::shared_ptr<const Discretisation>& discretisation) {
  constexpr double largest_share = 1e-3;
  const Discretisation& d = *discretisation;
  const auto size = static_cast<std::size_t>(d.local_size()),
             rows = static_cast<std::size_t>(3 * d.free_nodes);
  const std::vector<double> rest(size, 0.0);
  NewtonSolver newton(discretisation, Precision::single);
  if (!newton.factorise(rest)) return Precision::exact;
  // corrections of du/dx: z = -M^-1 (H [V; I])_f
  std::vector<double> tangent(3 * size), product(3 * size), step(size);
  newton.factor().tangent(tangent.data());
  double before = norm(tangent.data(), static_cast<std::int64_t>(tangent.size()));
  for (int round = 0; round < 2; ++round) {
    std::fill(product.begin(), product.end(), 0.0);
    d.elements.product(static_cast<std::int64_t>(size), rest.data(), tangent.data(), product.data());
    double square = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < rows; ++i) step[i] = -product[c * size + i];
      newton.factor().solve(step.data());
      for (std::size_t i = 0; i < rows; ++i) {
        tangent[c * size + i] += step[i];
        square += step[i] * step[i];
      }
    }
    const double moved = std::sqrt(square);
    if (!(moved <= largest_share * before)) return Precision::exact;
    before = moved;
  }
  return Precision::single;
}

}  // namespace forefeel
