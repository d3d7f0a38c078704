#include "solver/equilibrium/lane_solver.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/equilibrium/newton.hpp"

namespace forefeel {
namespace {

constexpr int most_iterations = 14;
// If the last correction of V changed K by the relative amount g, and a step with the factor leaves the share
// e of an error, the relative error of K that remains is about e g.
constexpr double settled_share = 1e-4, largest_gain = 3e-3, least_contraction = 0.03,
                 unknown_contraction = 0.2;

double& lane(std::vector<double>& v, std::size_t row, int l) {
  return v[row * lane_count + static_cast<std::size_t>(l)];
}

}  // namespace

LaneSolver::LaneSolver(std::shared_ptr<const Discretisation> discretisation)
    : d_(std::move(discretisation)), size_(static_cast<std::size_t>(d_->local_size()) * lane_count) {
  for (auto* v : {&u_, &residual_, &step_, &last_step_, &last_move_}) v->resize(size_);
  tangent_.resize(3 * size_);
  product_.resize(3 * size_);
  for (int i = 0; i < depth_; ++i) {
    step_change_[static_cast<std::size_t>(i)].resize(size_);
    move_[static_cast<std::size_t>(i)].resize(size_);
  }
}

void LaneSolver::load(const std::vector<LocalField*>& fields) {
  const std::size_t rows = size_ / lane_count;
  for (int l = 0; l < lane_count; ++l) {
    // idle lanes repeat the first state
    const LocalField& f =
        *fields[static_cast<std::size_t>(l) < fields.size() ? static_cast<std::size_t>(l) : 0];
    for (std::size_t i = 0; i < rows; ++i) {
      lane(u_, i, l) = f.u[i];
    }
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < rows; ++i)
        tangent_[c * size_ + i * lane_count + static_cast<std::size_t>(l)] = f.tangent[c * rows + i];
  }
}

// Stores the change of the step over the last move, and that move, as pair number `known` of a ring.
void LaneSolver::remember(int known) {
  const std::array<double, lane_count> minus = [] {
    std::array<double, lane_count> a{};
    a.fill(-1);
    return a;
  }();
  const auto at = static_cast<std::size_t>(known % depth_);
  step_change_[at] = step_;
  front_kernels().add_lanes(static_cast<std::int64_t>(3 * d_->free_nodes), minus.data(), last_step_.data(),
                            step_change_[at].data());
  move_[at].swap(last_move_);
}

// Replaces the step s by Anderson's: u + s - (Y + S) g, g = argmin |s - S g|, with S the changes of the step
// over the last iterations and Y the moves that caused them. Lanes that have ended get no step.
void LaneSolver::mix(int pairs, const std::array<double, lane_count>& active) {
  const FrontKernels& k = front_kernels();
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  const int known = std::min(pairs, depth_);
  std::array<std::array<double, lane_count>, depth_ * depth_> gram{};
  std::array<std::array<double, lane_count>, depth_> right{}, weight{};
  for (int i = 0; i < known; ++i) {
    const auto& si = step_change_[static_cast<std::size_t>(i)];
    k.dot_lanes(rows, si.data(), step_.data(), right[static_cast<std::size_t>(i)].data());
    for (int j = 0; j <= i; ++j)
      k.dot_lanes(rows, si.data(), step_change_[static_cast<std::size_t>(j)].data(),
                  gram[static_cast<std::size_t>(i * depth_ + j)].data());
  }
  for (std::size_t l = 0; l < lane_count; ++l) {
    if (known == 0 || active[l] == 0) continue;
    Eigen::Matrix<double, depth_, depth_> a = Eigen::Matrix<double, depth_, depth_>::Identity();
    Eigen::Matrix<double, depth_, 1> b = Eigen::Matrix<double, depth_, 1>::Zero();
    for (int i = 0; i < known; ++i) {
      b[i] = right[static_cast<std::size_t>(i)][l];
      for (int j = 0; j <= i; ++j) a(i, j) = a(j, i) = gram[static_cast<std::size_t>(i * depth_ + j)][l];
      a(i, i) *= 1 + 1e-10;
      if (!(a(i, i) > 0)) a(i, i) = 1;
    }
    const Eigen::Matrix<double, depth_, 1> g = a.ldlt().solve(b);
    if (!g.allFinite() || g.cwiseAbs().maxCoeff() > 10) continue;
    for (int i = 0; i < known; ++i) weight[static_cast<std::size_t>(i)][l] = -g[i];
  }
  for (int i = 0; i < known; ++i) {
    const auto at = static_cast<std::size_t>(i);
    k.add_lanes(rows, weight[at].data(), move_[at].data(), step_.data());
    k.add_lanes(rows, weight[at].data(), step_change_[at].data(), step_.data());
  }
}

bool LaneSolver::iterate(const Factorisation& factor, int count, double tolerance,
                         std::array<LaneResult, lane_count>& results) {
  const FrontKernels& k = front_kernels();
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  std::array<double, lane_count> active{}, energy{}, min_jacobian{}, squares{}, best{};
  for (int l = 0; l < count; ++l) active[static_cast<std::size_t>(l)] = 1;
  best.fill(std::numeric_limits<double>::infinity());
  bool mixing = false, previous = false;
  int pairs = 0;
  for (int iteration = 0;; ++iteration) {
    std::fill(residual_.begin(), residual_.end(), 0.0);
    d_->elements.gradient_lanes(u_.data(), residual_.data(), energy.data(), min_jacobian.data());
    k.dot_lanes(rows, residual_.data(), residual_.data(), squares.data());
    bool any = false, slow = false;
    for (int l = 0; l < count; ++l) {
      const auto at = static_cast<std::size_t>(l);
      if (active[at] == 0) continue;
      LaneResult& result = results[at];
      for (int i = 0; i < 3; ++i) result.force[i] = -lane(residual_, static_cast<std::size_t>(rows + i), l);
      result.energy = energy[at];
      result.min_jacobian = min_jacobian[at];
      result.residual = std::sqrt(squares[at]) / std::max(result.force.norm(), d_->force_floor);
      result.iterations = iteration;
      result.converged = result.residual <= tolerance && std::isfinite(result.energy);
      const bool hopeless = !std::isfinite(result.energy) || !std::isfinite(result.residual) ||
                            result.residual > 20 * best[at] || iteration == most_iterations;
      if (iteration > 0) result.contraction = std::max(result.contraction, result.residual / best[at]);
      slow = slow || (iteration > 0 && result.residual > 0.125 * best[at]);
      best[at] = std::min(best[at], result.residual);
      if (result.converged || hopeless) active[at] = 0;
      if (hopeless && !result.converged)  // finite values, so that the other lanes are not slowed down
        for (std::size_t i = 0; i < size_ / lane_count; ++i) lane(u_, i, l) = 0;
      any = any || active[at] != 0;
    }
    if (!any) break;
    for (std::size_t i = 0; i < size_; ++i) step_[i] = -residual_[i];
    factor.solve_lanes(step_.data());
    // Mixing costs as much as an element loop, so it starts only when a plain step reduces the residual less
    // than eightfold.
    mixing = mixing || slow;
    if (mixing) {
      if (previous) remember(pairs++);
      last_step_ = step_;
      mix(pairs, active);
      std::fill(last_move_.begin(), last_move_.end(), 0.0);
      k.add_lanes(rows, active.data(), step_.data(), last_move_.data());
      previous = true;
    }
    k.add_lanes(rows, active.data(), step_.data(), u_.data());
  }
  for (int l = 0; l < count; ++l)
    if (results[static_cast<std::size_t>(l)].converged) return true;
  return false;
}

void LaneSolver::finish(const Factorisation& factor, int count, int rounds,
                        std::array<LaneResult, lane_count>& results) {
  const FrontKernels& k = front_kernels();
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  std::array<double, lane_count> dot{}, one{};
  one.fill(1);
  for (int round = 0; round < rounds; ++round) {
    std::fill(product_.begin(), product_.end(), 0.0);
    d_->elements.product_lanes(static_cast<std::int64_t>(size_), u_.data(), tangent_.data(), product_.data());
    std::array<Mat3, lane_count> plain, gain;
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b) {
        const double* y = &product_[static_cast<std::size_t>(b) * size_];
        k.dot_lanes(rows, &tangent_[static_cast<std::size_t>(a) * size_], y, dot.data());
        for (int l = 0; l < count; ++l)
          plain[static_cast<std::size_t>(l)](a, b) = plain[static_cast<std::size_t>(l)](b, a) =
              dot[static_cast<std::size_t>(l)] + y[(rows + a) * lane_count + l];
      }
    for (int c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < size_; ++i) step_[i] = -product_[static_cast<std::size_t>(c) * size_ + i];
      factor.solve_lanes(step_.data());
      for (int a = 0; a <= c; ++a) {
        k.dot_lanes(rows, &product_[static_cast<std::size_t>(a) * size_], step_.data(), dot.data());
        for (int l = 0; l < count; ++l)
          gain[static_cast<std::size_t>(l)](a, c) = gain[static_cast<std::size_t>(l)](c, a) =
              -dot[static_cast<std::size_t>(l)];
      }
      k.add_lanes(rows, one.data(), step_.data(), &tangent_[static_cast<std::size_t>(c) * size_]);
    }
    bool settled = true;
    for (int l = 0; l < count; ++l) {
      LaneResult& result = results[static_cast<std::size_t>(l)];
      result.stiffness = plain[static_cast<std::size_t>(l)] - gain[static_cast<std::size_t>(l)];
      const double share = gain[static_cast<std::size_t>(l)].norm() / result.stiffness.norm();
      const double left =
          result.iterations > 0 ? std::max(result.contraction, least_contraction) : unknown_contraction;
      result.stiffness_settled = share <= largest_gain && left * share <= settled_share;
      settled = settled && (result.stiffness_settled || !result.converged);
    }
    if (settled) break;
  }
  for (int c = 0; c < 3; ++c) {
    k.dot_lanes(rows, &tangent_[static_cast<std::size_t>(c) * size_], residual_.data(), dot.data());
    for (int l = 0; l < count; ++l)
      if (results[static_cast<std::size_t>(l)].stiffness_settled)
        results[static_cast<std::size_t>(l)].force[c] -= dot[static_cast<std::size_t>(l)];
  }
}

void LaneSolver::solve(const Factorisation& factor, std::vector<LocalField*>& fields,
                       double residual_tolerance, std::array<LaneResult, lane_count>& results, int rounds) {
  results.fill({});
  const auto count = static_cast<int>(fields.size());
  load(fields);
  if (!iterate(factor, count, residual_tolerance, results)) return;
  finish(factor, count, rounds, results);
  const std::size_t rows = size_ / lane_count;
  for (int l = 0; l < count; ++l) {
    if (!results[static_cast<std::size_t>(l)].converged) continue;
    LocalField& f = *fields[static_cast<std::size_t>(l)];
    for (std::size_t i = 0; i < rows; ++i) {
      f.u[i] = lane(u_, i, l);
    }
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < rows; ++i)
        f.tangent[c * rows + i] = tangent_[c * size_ + i * lane_count + static_cast<std::size_t>(l)];
  }
}

bool detail::condense_alone(NewtonSolver& newton, LocalField& field, LaneResult& result) {
  if (!newton.factorise(field.u)) return false;
  const Discretisation& d = newton.discretisation();
  result.stiffness = newton.factor().stiffness();
  newton.factor().tangent(field.tangent.data());
  std::vector<double> gradient(field.u.size(), 0.0);
  d.elements.gradient(field.u.data(), gradient.data());
  const auto contact = static_cast<std::size_t>(3 * d.free_nodes);
  for (std::size_t c = 0; c < 3; ++c) {
    double force = -gradient[contact + c];
    for (std::size_t i = 0; i < contact; ++i) force -= field.tangent[c * gradient.size() + i] * gradient[i];
    result.force[static_cast<int>(c)] = force;
  }
  return true;
}

void detail::copy_result(const LaneResult& result, State& state) {
  state.status = SolveStatus::converged;
  state.force = result.force;
  state.stiffness = result.stiffness;
  state.energy = result.energy;
  state.iterations = result.iterations;
  state.residual = result.residual;
  state.min_jacobian = result.min_jacobian;
}

}  // namespace forefeel
