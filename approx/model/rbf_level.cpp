// Scaling and level of a set: its centre and size, and the highest kernel and degree whose polynomial it
// determines.
#include <algorithm>
#include <cmath>

#include "approx/model/rbf_fit.hpp"

namespace forefeel {
using namespace detail;

namespace {

constexpr double rank_tolerance = 1e-6;  // pivot ratio of P below which a polynomial term is not determined

// A quick test that is sufficient, not necessary: the last pivot of a pivoted Cholesky is at least det /
// (product of the other diagonal entries), and the determinant needs no pivoting.
bool surely_full_rank(std::size_t q, const double* gram) {
  double rest[max_terms][max_terms], correlation = 1, least = gram[0], most = gram[0];
  for (std::size_t i = 0; i < q; ++i) std::copy_n(gram + i * q, i + 1, rest[i]);
  for (std::size_t j = 0; j < q; ++j) {
    const double entry = gram[j * q + j], pivot = rest[j][j];
    if (!(pivot > 1e-9 * entry)) return false;  // rounding would count
    least = std::min(least, entry);
    most = std::max(most, entry);
    correlation *= pivot / entry;
    const double inverse = 1 / pivot;
    for (std::size_t i = j + 1; i < q; ++i) {
      const double share = rest[i][j] * inverse;
      for (std::size_t k = j + 1; k <= i; ++k) rest[i][k] -= share * rest[k][j];
    }
  }
  return correlation * least > 10 * rank_tolerance * rank_tolerance * most;
}

// Pivoted Cholesky of the q x q Gram matrix (lower triangle, overwritten): its pivots are the squares of
// those of a pivoted QR of P.
bool full_rank(std::size_t q, double* gram) {
  if (surely_full_rank(q, gram)) return true;
  const auto entry = [&](std::size_t i, std::size_t j) -> double& {
    return i > j ? gram[i * q + j] : gram[j * q + i];
  };
  double first = 0;
  bool done[max_terms] = {};
  for (std::size_t step = 0; step < q; ++step) {
    std::size_t best = q;
    for (std::size_t i = 0; i < q; ++i)
      if (!done[i] && (best == q || entry(i, i) > entry(best, best))) best = i;
    const double pivot = entry(best, best);
    if (step == 0) first = pivot;
    if (!(pivot > rank_tolerance * rank_tolerance * first)) return false;
    done[best] = true;
    for (std::size_t i = 0; i < q; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        if (!done[i] && !done[j]) entry(i, j) -= entry(i, best) * entry(j, best) / pivot;
  }
  return true;
}

}  // namespace

// Centre and scale, so that the set fills the unit ball. In a set with weights each state counts by its
// weight: a far state of little weight then changes neither the rank of the polynomial nor the meaning of a
// ridge.
void RbfFit::set_frame(std::span<const Sample> samples) {
  const bool weighted = samples[0].weighted;
  double total = 0, largest = 0;
  scaling_.centre.setZero();
  for (const auto& s : samples) {
    const double w = !weighted ? 1 : s.state ? s.weight : 0;
    total += w;
    scaling_.centre += w * (s.at - samples[0].at);
  }
  scaling_.centre = samples[0].at + scaling_.centre / total;
  for (const auto& s : samples) {
    const double w = !weighted ? 1 : s.state ? s.weight : 0;
    largest = std::max(largest, w * (s.at - scaling_.centre).norm());
  }
  if (weighted) largest = std::max(largest, least_size * options_.length);
  scaling_.scale = largest > 0 ? largest : options_.length > 0 ? options_.length : 1;
  scaling_.inverse_scale = 1 / scaling_.scale;
}

// The highest level whose polynomial the samples determine.
RbfFit::Level RbfFit::level_for(std::span<const Sample> samples) {
  Level level{power_of(options_.kernel), options_.kernel == Kernel::quintic ? 2 : 1,
              options_.data == Data::force_and_stiffness};
  // The auxiliary places determine the polynomial, however small the set is.
  if (std::ranges::any_of(samples, [](const Sample& s) { return !s.state; })) return level;
  for (;; --level.degree) {
    if (level.degree < 2) level.power = level.degree == 0 ? 1 : std::min(level.power, 3);
    if (level.degree == 0) {
      level.hermite = false;
      return level;
    }
    const std::size_t q = polynomial_terms(level.degree);
    double gram[max_terms * max_terms] = {}, l[max_terms], gradient[3 * max_terms];
    for (const auto& s : samples) {
      const Vec3 y = scaling_.scaled(s.at);
      lagrange(level.degree, y.data(), l, gradient);
      const bool both = level.hermite && s.stiffness.allFinite();
      for (std::size_t i = 0; i < q; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
          gram[i * q + j] += l[i] * l[j];
          for (std::size_t d = 0; both && d < 3; ++d)
            gram[i * q + j] += gradient[3 * i + d] * gradient[3 * j + d];
        }
    }
    if (full_rank(q, gram)) return level;
  }
}

// True if level_for would give the present level. Uses the rows that are there, unless the set has stepped
// down.
bool RbfFit::level_still_fits() {
  const int wanted = options_.kernel == Kernel::quintic ? 2 : 1;
  if (level_.degree == wanted) {
    double gram[max_terms * max_terms];
    std::fill_n(rows_.weight.data() + set_.slots * rows_.per_slot, 8, 0.0);
    dense::loops().gram(rows_.terms, set_.slots * rows_.per_slot, rows_.lagrange.data(), rows_.stride,
                        rows_.weight.data(), gram);
    return full_rank(rows_.terms, gram);
  }
  gather();
  const Level level = level_for(scratch_.gathered);
  return level.power == level_.power && level.degree == level_.degree && level.hermite == level_.hermite;
}

}  // namespace forefeel
