// Checks of a kept factor, and iterative refinement of the coefficients.

#include <algorithm>
#include <cmath>
#include <limits>

#include "approx/loops/exact_sums.hpp"
#include "approx/model/rbf_fit.hpp"

namespace forefeel {
using namespace detail;

namespace {

// Number of states checked at a time. Evaluating a model there costs little compared with its update.
constexpr std::size_t watched(std::size_t n) {
  return n <= 16 ? n : n <= 32 ? 16 : 8;
}
// Limits beyond which digits count as lost. Factors of lattice sets, fresh or updated, stay below them by a
// factor of two or more (25 to 75 Hermite states, 100 to 300 plain ones).
constexpr double lost = 3e-14;        // misfit, per 100 rows, and P^T lambda, in units of the largest force
constexpr double least_pivot = 1e-5;  // of K
constexpr double least_determined = 1e-3;  // pivot ratio of P
constexpr int most_refinements = 6;
constexpr std::size_t most_refined = 32;  // states; a refit of more takes less time than a refinement
constexpr double settled = 1e-8;          // last correction against the coefficients

}  // namespace

bool RbfFit::has_lost_digits(const ModelData& out) {
  const std::size_t n = set_.living.size(), q = rows_.terms;
  const auto [weakest, inverse] = factor_.weakest_row();
  double least = std::abs(solution_.upper[0]), most = least;
  for (std::size_t j = 1; j < q; ++j) {
    least = std::min(least, std::abs(solution_.upper[j * q + j]));
    most = std::max(most, std::abs(solution_.upper[j * q + j]));
  }
  if (!(inverse * inverse * least_pivot < 1) || !(least > least_determined * most)) return true;

  double largest = 0;
  for (const std::uint32_t s : set_.living) largest = std::max(largest, set_.array(Slots::force_norm)[s]);
  double sums[3 * max_terms];
  dense::loops().dots3(q, factor_.rows(), rows_.orthogonal.data() + q * rows_.stride, rows_.lagrange.data(),
                       rows_.stride, sums);
  for (std::size_t k = 0; k < 3 * q; ++k)
    if (!(std::abs(sums[k]) <= lost * largest)) {
      wear_.worn = wear_.updated;
      return true;
    }

  const double per_row = out.sum.power == 5 && !out.sum.hermite ? 0.04 : 0.01;  // r^5 alone loses more
  const double allowed = lost * largest * std::max(0.4, per_row * double(factor_.rows()));
  const auto missed = [&](std::size_t i) {
    const std::uint32_t s = set_.living[i];
    if (set_.slot[s].dropped != 0) return false;
    const double y[3] = {set_.px[s], set_.py[s], set_.pz[s]};
    double f[3];
    out.sum.raw(y, f);
    double squared = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double left = set_.array(Slots::force + c)[s] - f[c] -
                          rows_.sign * ridge(s, 0) * out.sum.data[(3 + c) * out.sum.stride + i];
      squared += left * left;
    }
    return !(squared <= allowed * allowed);
  };
  // Checks the state with the smallest pivot, where errors appear first, and others in turn.
  bool lost_some = false;
  const auto at = std::ranges::lower_bound(set_.living, static_cast<std::uint32_t>(weakest / rows_.per_slot));
  if (at != set_.living.end()) lost_some = missed(static_cast<std::size_t>(at - set_.living.begin()));
  if (!wear_.updated) wear_.watched = 0;
  for (std::size_t t = 0; t < watched(n) && !lost_some; ++t) {
    wear_.watched = wear_.watched + 1 < n ? wear_.watched + 1 : 0;
    lost_some = missed(wear_.watched);
  }
  if (lost_some) wear_.worn = wear_.updated;
  return lost_some;
}

// The misfit of the model at its states, into refinement_.misfit and, in the order of the factor's rows, into
// refinement_.correction. Returns its largest entry.
double RbfFit::misfit(const ModelData& out) {
  const std::size_t b = rows_.per_slot;
  exact::loops().misfit(out.sum.power, b == 4, out.sum.padded, out.sum.data.data(), out.sum.stride,
                        out.sum.polynomial[0].data(), refinement_.given.data(), refinement_.stride,
                        refinement_.misfit.data());
  double largest = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    double* to = refinement_.correction.data() + c * rows_.stride;
    std::fill_n(to, rows_.stride, 0.0);  // all of it: an earlier, larger set must leave nothing
    for (std::size_t i = 0; i < set_.living.size(); ++i)
      for (std::size_t t = 0; t < b; ++t) {
        const std::size_t row = set_.living[i] * b + t;
        if (rows_.weight[row] == 0) continue;
        const std::size_t array = t == 0 ? c : 2 + 3 * c + t;
        const double left =
            refinement_.misfit[array * refinement_.stride + i] -
            rows_.sign * ridge(set_.living[i], t) * out.sum.data[(3 + array) * out.sum.stride + i];
        to[row] = left;
        largest = std::max(largest, std::abs(left));
      }
  }
  return largest;
}

// rest = -P^T lambda, which should be zero.
void RbfFit::constraint(const ModelData& out, double* rest) const {
  const std::size_t b = rows_.per_slot, q = rows_.terms;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = 0; j < q; ++j) {
      long double sum = 0;
      for (std::size_t i = 0; i < set_.living.size(); ++i)
        for (std::size_t t = 0; t < b; ++t)
          sum -= static_cast<long double>(
                     out.sum.data[(3 + (t == 0 ? c : 2 + 3 * c + t)) * out.sum.stride + i]) *
                 rows_.lagrange[j * rows_.stride + set_.living[i] * b + t];
      rest[c * q + j] = rows_.sign * static_cast<double>(sum);
    }
}

// Adds `by` (1 or -1) times the correction to the model.
void RbfFit::correct(ModelData& out, double by) {
  const std::size_t b = rows_.per_slot;
  for (std::size_t c = 0; c < 3; ++c) {
    const double* lambda = refinement_.correction.data() + c * rows_.stride;
    for (std::size_t i = 0; i < set_.living.size(); ++i)
      for (std::size_t t = 0; t < b; ++t)
        out.sum.data[(3 + (t == 0 ? c : 2 + 3 * c + t)) * out.sum.stride + i] +=
            by * rows_.sign * lambda[set_.living[i] * b + t];
    for (std::size_t t = 0; t < max_terms; ++t) out.sum.polynomial[t][c] += by * refinement_.polynomial[c][t];
  }
}

// A round of refinement sums over all pairs of states in twice the working precision, so for larger sets a
// refit is faster.
bool RbfFit::refit_is_cheaper() const {
  return mode_ == Mode::automatic && wear_.updated && set_.alive > most_refined;
}

// The data that the model must reproduce at its own states: forces, and derivatives if it uses stiffness.
void RbfFit::load_given() {
  for (std::size_t i = 0; i < set_.living.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t s = set_.living[i];
      refinement_.given[c * refinement_.stride + i] = set_.array(Slots::force + c)[s];
      if (rows_.per_slot == 4)
        for (std::size_t d = 0; d < 3; ++d)
          refinement_.given[(3 + 3 * c + d) * refinement_.stride + i] =
              -set_.array(Slots::stiffness + 3 * c + d)[s] * scaling_.scale;
    }
}

// Solves for the change of the coefficients that removes the misfit, with the present factor: refinement_.correction
// (of lambda) and refinement_.polynomial.
void RbfFit::solve_correction(const ModelData& out) {
  const std::size_t q = rows_.terms, m = factor_.rows();
  // With w = L^T delta lambda: Q^T w = R^-T rest and w = L^-1 misfit beyond Q.
  double rest[3 * max_terms];
  constraint(out, rest);
  factor_.solve(refinement_.correction.data(), rows_.stride);
  for (std::size_t c = 0; c < 3; ++c) {
    std::fill_n(refinement_.correction.data() + c * rows_.stride + m, 8, 0.0);
    for (std::size_t j = 0; j < q; ++j) {
      double value = rest[c * q + j];
      for (std::size_t k = 0; k < j; ++k) value -= solution_.upper[k * q + j] * rest[c * q + k];
      rest[c * q + j] = value / solution_.upper[j * q + j];
    }
  }
  double along[3 * max_terms], total[3 * max_terms] = {};
  for (int pass = 0; pass < 2; ++pass) {  // the second pass removes the rounding error of the first
    dense::loops().dots3(q, m, refinement_.correction.data(), rows_.orthogonal.data(), rows_.stride, along);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t j = 0; j < q; ++j) {
        const double taken = along[c * q + j] - rest[c * q + j];
        total[c * q + j] += taken;
        for (std::size_t r = 0; r < m; ++r)
          refinement_.correction[c * rows_.stride + r] -= taken * rows_.orthogonal[j * rows_.stride + r];
      }
  }
  double* z = refinement_.correction.data();
  factor_.solve_transposed(z, z + rows_.stride, z + 2 * rows_.stride);
  for (std::size_t c = 0; c < 3; ++c) std::fill_n(z + c * rows_.stride + m, 8, 0.0);
  double sums[3 * max_terms];
  dense::loops().dots3(q, m, z, rows_.dual.data(), rows_.stride, sums);
  for (std::size_t c = 0; c < 3; ++c) {
    double values[max_terms];
    for (std::size_t j = q; j-- > 0;) {
      double value = total[c * q + j];
      for (std::size_t k = j + 1; k < q; ++k) value -= solution_.upper[j * q + k] * values[k];
      values[j] = value / solution_.upper[j * q + j];
    }
    for (std::size_t j = 0; j < q; ++j) values[j] -= rows_.sign * sums[c * q + j];
    to_monomials(level_.degree, values, refinement_.polynomial[c]);
  }
}

// Iterative refinement of the coefficients. False if it did not converge: the factor has lost too many
// digits.
bool RbfFit::refine(ModelData& out) {
  load_given();
  const double before = misfit(out);
  double last = std::numeric_limits<double>::infinity();
  for (int round = 0; round < most_refinements; ++round) {
    solve_correction(out);
    const double* z = refinement_.correction.data();
    double size = 0;
    for (std::size_t i = 0; i < 3 * rows_.stride; ++i) size = std::max(size, std::abs(z[i]));
    // Stop if it no longer converges or is not a number. The first rounds may reduce one component after the
    // other.
    if (!(size < (round < 3 ? 2 : 0.5) * last)) break;
    last = size;
    correct(out, 1);
    std::copy_n(refinement_.correction.data(), 3 * rows_.stride, refinement_.last_correction.data());
    const double after = misfit(out);
    if (after <= 2 * before) continue;
    std::copy_n(refinement_.last_correction.data(), 3 * rows_.stride,
                refinement_.correction.data());  // made it worse: undo
    correct(out, -1);
    return false;
  }
  double largest = 0;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < set_.living.size(); ++i)
      largest = std::max(largest, std::abs(out.sum.data[(3 + c) * out.sum.stride + i]));
  return last <= settled * largest;
}

}  // namespace forefeel
