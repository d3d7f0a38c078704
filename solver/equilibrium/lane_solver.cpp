#include "solver/equilibrium/lane_solver.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/equilibrium/newton.hpp"

namespace forefeel {

namespace {

constexpr int most_iterations = 20, most_retreats = 6;
constexpr double allowed_growth = 2;   // of the residual in one step without progress
constexpr int most_stale = 2;          // steps without progress
constexpr int factor_life = 7;         // iterations before a new factor is made
constexpr double worth_a_factor = 30;  // residual over tolerance

double& lane(std::vector<double>& v, std::size_t row, std::size_t l) {
  return v[row * lane_count + l];
}

}  // namespace

LaneSolver::LaneSolver(std::shared_ptr<const Discretisation> discretisation)
    : d_(std::move(discretisation)), size_(static_cast<std::size_t>(d_->local_size()) * lane_count) {
  for (auto* v : {&u_, &residual_, &step_, &last_step_, &last_move_}) v->resize(size_);
  tangent_.resize(3 * size_);
  product_.resize(3 * size_);
  history_.resize(2 * depth_ * size_);
}

void LaneSolver::load(const std::vector<LocalField*>& fields) {
  const std::size_t rows = size_ / lane_count;
  for (std::size_t l = 0; l < lane_count; ++l) {
    const LocalField& f = *fields[l < fields.size() ? l : 0];  // idle lanes repeat the first state
    for (std::size_t i = 0; i < rows; ++i) {
      lane(u_, i, l) = f.u[i];
    }
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < rows; ++i)
        tangent_[c * size_ + i * lane_count + l] = f.tangent[c * rows + i];
  }
}

// Stores the change of the step over the last move, and that move, as pair number `known` of a ring. Lanes that did not
// move get an empty pair.
void LaneSolver::remember(int known, const LaneMask& moved) {
  const std::size_t at = static_cast<std::size_t>(known) % depth_;
  double *change = step_change(at), *moves = move(at);
  for (std::size_t i = 0; i < size_; i += lane_count)
    for (std::size_t l = 0; l < lane_count; ++l) {
      change[i + l] = moved[l] != 0 ? step_[i + l] - last_step_[i + l] : 0.0;
      moves[i + l] = moved[l] != 0 ? last_move_[i + l] : 0.0;
    }
}

// Replaces the step s by Anderson's: u + s - (Y + S) g, g = argmin |s - S g|, with S the changes of the step
// over the last iterations and Y the moves that caused them. Lanes that have ended get no step.
void LaneSolver::mix(int pairs, const LaneMask& active) {
  const FrontKernels& k = front_kernels();
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  const std::size_t known = std::min(static_cast<std::size_t>(pairs), depth_);
  std::array<std::array<double, lane_count>, depth_ * depth_> gram{};
  std::array<std::array<double, lane_count>, depth_> right{}, weight{};
  for (std::size_t i = 0; i < known; ++i) {
    const double* si = step_change(i);
    k.dot_lanes(rows, si, step_.data(), right[i].data());
    for (std::size_t j = 0; j <= i; ++j) k.dot_lanes(rows, si, step_change(j), gram[i * depth_ + j].data());
  }
  for (std::size_t l = 0; l < lane_count; ++l) {
    if (known == 0 || active[l] == 0) continue;
    Eigen::Matrix<double, depth_, depth_> a = Eigen::Matrix<double, depth_, depth_>::Identity();
    Eigen::Matrix<double, depth_, 1> b = Eigen::Matrix<double, depth_, 1>::Zero();
    for (unsigned i = 0; i < known; ++i) {
      b[i] = right[i][l];
      for (unsigned j = 0; j <= i; ++j) a(i, j) = a(j, i) = gram[i * depth_ + j][l];
      a(i, i) *= 1 + 1e-10;
      if (!(a(i, i) > 0)) a(i, i) = 1;
    }
    const Eigen::Matrix<double, depth_, 1> g = a.ldlt().solve(b);
    if (!g.allFinite() || g.cwiseAbs().maxCoeff() > 10) continue;
    for (unsigned i = 0; i < known; ++i) weight[i][l] = -g[i];
  }
  for (std::size_t i = 0; i < known; ++i) {
    k.add_lanes(rows, weight[i].data(), move(i), step_.data());
    k.add_lanes(rows, weight[i].data(), step_change(i), step_.data());
  }
}

// Evaluates all lanes. Each has converged, continues, undoes half of its last step, or is given up.
void LaneSolver::judge(int count, double tolerance, int iteration, LaneProgress& at,
                       std::array<LaneResult, lane_count>& results) {
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  LaneMask energy{}, min_jacobian{}, squares{};
  at.worst = 0;
  std::fill(residual_.begin(), residual_.end(), 0.0);
  d_->elements.gradient_lanes(u_.data(), residual_.data(), energy.data(), min_jacobian.data());
  front_kernels().dot_lanes(rows, residual_.data(), residual_.data(), squares.data());
  for (std::size_t l = 0; l < static_cast<std::size_t>(count); ++l) {
    const bool open = at.active[l] != 0 || at.retreat[l] != 0;
    if (!open) continue;
    LaneResult& result = results[l];
    Vec3 force;
    for (int i = 0; i < 3; ++i) force[i] = -lane(residual_, static_cast<std::size_t>(rows + i), l);
    const double residual = std::sqrt(squares[l]) / std::max(force.norm(), d_->force_floor);
    const bool finite = std::isfinite(energy[l]) && std::isfinite(residual);
    const bool progress = at.iterations[l] == 0 || residual <= tolerance || residual < 0.9 * at.best[l] ||
                          energy[l] < at.least_energy[l] - 1e-12 * std::abs(at.least_energy[l]);
    const bool good =
        finite && (progress || (residual <= allowed_growth * result.residual && at.stale[l] < most_stale));
    const bool given_up =
        iteration == most_iterations || (!good && (at.iterations[l] == 0 || at.retreats[l] == most_retreats));
    at.active[l] = at.retreat[l] = at.moved[l] = 0;
    if (good) {
      if (at.iterations[l] > 0) {
        result.contraction = std::max(result.contraction, residual / at.best[l]);
        at.slow = at.slow || residual > 0.125 * at.best[l];
        at.moved[l] = 1;
      }
      at.best[l] = std::min(at.best[l], residual);
      at.least_energy[l] = std::min(at.least_energy[l], energy[l]);
      at.stale[l] = progress ? 0 : at.stale[l] + 1;
      at.worst = std::max(at.worst, residual);
      at.retreats[l] = 0;
      result.force = force;
      result.energy = energy[l];
      result.min_jacobian = min_jacobian[l];
      result.residual = residual;
      result.iterations = at.iterations[l]++;
      result.converged = residual <= tolerance;
      if (result.converged) continue;
    }
    if (given_up) {  // finite values, so that the other lanes are not slowed down
      for (std::size_t i = 0; i < size_ / lane_count; ++i) lane(u_, i, l) = 0;
      continue;
    }
    (good ? at.active : at.retreat)[l] = 1;
    at.retreats[l] += good ? 0 : 1;
  }
}

// Mean of u over the lanes of the mask.
std::vector<double> LaneSolver::mean_of(const LaneMask& mask) const {
  double count = 0;
  for (const double m : mask) count += m;
  std::vector<double> mean(size_ / lane_count, 0.0);
  for (std::size_t i = 0; i < mean.size(); ++i)
    for (std::size_t l = 0; l < lane_count; ++l)
      if (mask[l] != 0) mean[i] += u_[i * lane_count + l] / count;
  return mean;
}

bool LaneSolver::iterate(const Factorisation& factor, NewtonSolver* newton, int count, double tolerance,
                         std::array<LaneResult, lane_count>& results) {
  const FrontKernels& k = front_kernels();
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  LaneProgress at;
  std::fill_n(at.active.begin(), count, 1.0);
  at.best.fill(std::numeric_limits<double>::infinity());
  at.least_energy = at.best;
  bool mixing = false, previous = false;
  int pairs = 0, age = 0;
  const auto any = [](const LaneMask& mask) {
    return std::ranges::any_of(mask, [](double m) { return m != 0; });
  };
  for (int iteration = 0;; ++iteration) {
    judge(count, tolerance, iteration, at, results);
    if (any(at.retreat)) {
      LaneMask half, back;
      for (std::size_t l = 0; l < lane_count; ++l) {
        half[l] = -0.5 * at.retreat[l];
        back[l] = -at.retreat[l];
      }
      k.add_lanes(rows, half.data(), last_move_.data(), last_move_.data());
      k.add_lanes(rows, back.data(), last_move_.data(), u_.data());
      mixing = true;
    }
    if (!any(at.active)) {
      if (any(at.retreat)) continue;
      break;
    }
    if (newton && ++age > factor_life && at.worst > worth_a_factor * tolerance) {
      if (!newton->factorise_shifted(mean_of(at.active))) break;
      age = pairs = 0;
      previous = false;
    }
    for (std::size_t i = 0; i < size_; ++i) step_[i] = -residual_[i];
    factor.solve_lanes(step_.data());
    // Mixing costs as much as an element loop, so it starts only when a plain step reduces the residual less
    // than eightfold.
    mixing = mixing || at.slow;
    if (mixing && previous) remember(pairs++, at.moved);
    replace_lanes(at.active, step_, last_step_);
    if (mixing) mix(pairs, at.active);
    previous = true;
    replace_lanes(at.active, step_, last_move_);
    k.add_lanes(rows, at.active.data(), step_.data(), u_.data());
  }
  return std::any_of(results.begin(), results.begin() + count,
                     [](const LaneResult& r) { return r.converged; });
}

void LaneSolver::scale_lanes(const LaneMask& factor, double* v, std::size_t size) {
  for (std::size_t i = 0; i < size; i += lane_count)
    for (std::size_t l = 0; l < lane_count; ++l) v[i + l] *= factor[l];
}

// Copies the lanes of the mask.
void LaneSolver::replace_lanes(const LaneMask& mask, const std::vector<double>& from,
                               std::vector<double>& to) {
  for (std::size_t i = 0; i < to.size(); i += lane_count)
    for (std::size_t l = 0; l < lane_count; ++l) to[i + l] = mask[l] != 0 ? from[i + l] : to[i + l];
}

std::array<double, lane_count> LaneSolver::residuals(const std::vector<LocalField*>& fields) {
  for (std::size_t l = 0; l < lane_count; ++l) {
    const std::vector<double>& u = fields[l < fields.size() ? l : 0]->u;
    for (std::size_t i = 0; i < u.size(); ++i) u_[i * lane_count + l] = u[i];
  }
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  LaneMask energy{}, min_jacobian{}, found{};
  std::fill(residual_.begin(), residual_.end(), 0.0);
  d_->elements.gradient_lanes(u_.data(), residual_.data(), energy.data(), min_jacobian.data());
  front_kernels().dot_lanes(rows, residual_.data(), residual_.data(), found.data());
  for (std::size_t l = 0; l < lane_count; ++l) {
    Vec3 force;
    for (int i = 0; i < 3; ++i) force[i] = lane(residual_, static_cast<std::size_t>(rows + i), l);
    const double residual = std::sqrt(found[l]) / std::max(force.norm(), d_->force_floor);
    found[l] = std::isfinite(energy[l]) && std::isfinite(residual) ? residual
                                                                   : std::numeric_limits<double>::infinity();
  }
  return found;
}

void LaneSolver::solve(const Factorisation& factor, std::vector<LocalField*>& fields,
                       double residual_tolerance, std::array<LaneResult, lane_count>& results, int rounds,
                       NewtonSolver* newton) {
  results.fill({});
  const auto count = static_cast<int>(fields.size());
  load(fields);
  if (!iterate(factor, newton, count, residual_tolerance, results)) return;
  finish(factor, count, rounds, results);
  const std::size_t rows = size_ / lane_count;
  for (std::size_t l = 0; l < fields.size(); ++l) {
    if (!results[l].converged) continue;
    LocalField& f = *fields[l];
    for (std::size_t i = 0; i < rows; ++i) {
      f.u[i] = lane(u_, i, l);
    }
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < rows; ++i)
        f.tangent[c * rows + i] = tangent_[c * size_ + i * lane_count + l];
  }
}

bool detail::condense_alone(NewtonSolver& newton, LocalField& field, LaneResult& result) {
  if (!newton.factorise(field.u)) return false;
  const Discretisation& d = newton.discretisation();
  if (!newton.condense(field.u, 0, field.tangent.data(), result.stiffness)) return false;
  std::vector<double> gradient(field.u.size(), 0.0);
  d.elements.gradient(field.u.data(), gradient.data());
  const auto contact = static_cast<std::size_t>(3 * d.free_nodes);
  for (unsigned c = 0; c < 3; ++c) {
    double force = -gradient[contact + c];
    for (std::size_t i = 0; i < contact; ++i) force -= field.tangent[c * gradient.size() + i] * gradient[i];
    result.force[c] = force;
  }
  return true;
}

void detail::copy_result(const LaneResult& result, State& state) {
  state.solve.status = SolveStatus::converged;
  state.force = result.force;
  state.stiffness = result.stiffness;
  state.energy = result.energy;
  state.solve.iterations = result.iterations;
  state.solve.residual = result.residual;
  state.solve.min_jacobian = result.min_jacobian;
}

// K and V of the states of a lane solver, by conjugate gradients.

namespace {

// If the last correction of V changed K by the relative amount g, and a step with the factor leaves the share
// e of an error, the relative error of K that remains is about e g.
constexpr double settled_share = 2e-5, largest_gain = 3e-3, least_contraction = 0.03, most_contraction = 0.7,
                 unknown_contraction = 0.2;

}  // namespace

// Conjugate gradients for V, preconditioned with M, for each lane and each column c of V:
//   rho = -(H [V; I])_f   z = M^-1 rho   p = z + p rho^T z / (rho^T z)'   V += p rho^T z / (p^T H p)
// y = H [V; I] (product_) follows by y += H p alpha. At the end V += z.
void LaneSolver::finish(const Factorisation& factor, int count, int rounds,
                        std::array<LaneResult, lane_count>& results) {
  const FrontKernels& k = front_kernels();
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  const auto stride = static_cast<std::int64_t>(size_);
  double *z = history_.data(), *p = z + 3 * size_, *q = p + 3 * size_;
  std::fill_n(p, 3 * size_, 0.0);
  std::array<LaneMask, 3> before{};
  LaneMask one;
  one.fill(1);
  std::fill(product_.begin(), product_.end(), 0.0);
  d_->elements.product_lanes(stride, u_.data(), tangent_.data(), product_.data());
  for (int round = 0;; ++round) {
    for (std::size_t i = 0; i < 3 * size_; ++i) z[i] = -product_[i];
    factor.solve_lanes(z, 3, stride);
    for (std::size_t c = 0; c < 3; ++c)
      std::fill_n(&z[c * size_ + static_cast<std::size_t>(rows) * lane_count], 6 * lane_count, 0.0);
    std::array<LaneMask, 3> square;
    const bool settled = condense_lanes(z, count, results, square);
    if (settled || round + 1 >= rounds) break;
    for (std::size_t c = 0; c < 3; ++c) {
      LaneMask share;
      for (std::size_t l = 0; l < lane_count; ++l)
        share[l] = round > 0 && before[c][l] > 0 ? square[c][l] / before[c][l] : 0.0;
      scale_lanes(share, &p[c * size_], size_);
      k.add_lanes(stride / lane_count, one.data(), &z[c * size_], &p[c * size_]);
    }
    std::fill_n(q, 3 * size_, 0.0);
    d_->elements.product_lanes(stride, u_.data(), p, q);
    for (std::size_t c = 0; c < 3; ++c) {
      LaneMask length;
      k.dot_lanes(rows, &p[c * size_], &q[c * size_], length.data());
      for (std::size_t l = 0; l < lane_count; ++l)
        length[l] = length[l] > 0 ? square[c][l] / length[l] : 0.0;  // otherwise H is not positive definite
      k.add_lanes(stride / lane_count, length.data(), &p[c * size_], &tangent_[c * size_]);
      k.add_lanes(stride / lane_count, length.data(), &q[c * size_], &product_[c * size_]);
    }
    before = square;
  }
  LaneMask dot{};
  for (unsigned c = 0; c < 3; ++c) {
    k.add_lanes(stride / lane_count, one.data(), &z[c * size_], &tangent_[c * size_]);
    k.dot_lanes(rows, &tangent_[c * size_], residual_.data(), dot.data());
    for (std::size_t l = 0; l < static_cast<std::size_t>(count); ++l)
      if (results[l].stiffness_settled) results[l].force[c] -= dot[l];
  }
}

// K from V, y = H [V; I] and z, the correction of V; square: rho^T z by column. True if K is valid in all lanes that
// converged.
bool LaneSolver::condense_lanes(const double* z, int count, std::array<LaneResult, lane_count>& results,
                                std::array<LaneMask, 3>& square) const {
  const FrontKernels& k = front_kernels();
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  std::array<Mat3, lane_count> plain, gain;
  LaneMask dot{};
  for (unsigned a = 0; a < 3; ++a)
    for (unsigned b = a; b < 3; ++b) {
      const double* y = &product_[b * size_];
      k.dot_lanes(rows, &tangent_[a * size_], y, dot.data());
      for (std::size_t l = 0; l < lane_count; ++l)
        plain[l](a, b) = plain[l](b, a) = dot[l] + y[(static_cast<std::size_t>(rows) + a) * lane_count + l];
      k.dot_lanes(rows, &product_[a * size_], &z[b * size_], dot.data());
      for (std::size_t l = 0; l < lane_count; ++l) gain[l](a, b) = gain[l](b, a) = -dot[l];
    }
  for (unsigned c = 0; c < 3; ++c)
    for (std::size_t l = 0; l < lane_count; ++l) square[c][l] = gain[l](c, c);
  bool settled = true;
  for (std::size_t l = 0; l < static_cast<std::size_t>(count); ++l) {
    LaneResult& result = results[l];
    result.stiffness = plain[l] - gain[l];
    const double share = gain[l].norm() / result.stiffness.norm();
    const double left = result.iterations > 0
                            ? std::clamp(result.contraction, least_contraction, most_contraction)
                            : unknown_contraction;
    result.stiffness_settled = share <= largest_gain && left * share <= settled_share;
    settled = settled && (result.stiffness_settled || !result.converged);
  }
  return settled;
}

}  // namespace forefeel
