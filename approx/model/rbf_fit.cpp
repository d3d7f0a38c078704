#include "approx/model/rbf_fit.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "approx/loops/kernel_rows.hpp"

namespace forefeel {
using namespace detail;

namespace {

// Pivots, relative to the diagonal, below which a row counts as a near-duplicate: rounding cannot tell it
// from the other rows. The pivot of a value at the distance e from another one is of order e^2 (e for r);
// with Hermite data it is e^3 (r^3) or e^4 (r^5). In the last case the gradients there determine nearly all
// of it, so the limit is higher.
double pivot_tolerance(int power, bool hermite, bool value) {
  if (!hermite) return 1e-15;
  return power == 5 && value ? 1e-11 : 1e-14;
}
// Ridge of a set with weights, large enough that no row is ever dropped: dropping one would change the model
// at once.
double least_ridge(int power, bool hermite, bool value) {
  return 10 * std::max(pivot_tolerance(power, hermite, value), 1e-14);
}
// Pivot of the last functional at the border of a lattice set, in units of h^k: median over half balls.
double border_pivot(int power, bool hermite, bool value) {
  if (!hermite) return power == 5 ? 3 : 0.9;
  return value ? (power == 5 ? 1 : 0.6) : 2;
}

double power(double r2, int k) {
  const double r = std::sqrt(r2);
  return k == 1 ? r : k == 3 ? r * r2 : r * r2 * r2;
}

}  // namespace

RbfFit::RbfFit(const ModelOptions& options, std::size_t capacity)
    : options_(options), room_{std::max<std::size_t>(capacity, 1), 0} {
  const bool hermite = options.data == Data::force_and_stiffness;
  const std::size_t rows = hermite ? 4 : 1;
  room_.slots = room_.states + std::max<std::size_t>(hermite ? 8 : 32, room_.states / 8) + DenseFactor::panel;
  factor_ = DenseFactor(rows * room_.slots + DenseFactor::panel);
  set_.slot.resize(room_.slots + DenseFactor::panel);
  rows_.stride = (factor_.row_capacity() + 23) / 8 * 8;
  for (auto* v : {&set_.px, &set_.py, &set_.pz}) v->assign(room_.slots + 2 * DenseFactor::panel, 0.0);
  set_.stride = (room_.slots + 2 * DenseFactor::panel + 7) / 8 * 8;
  set_.data.assign(Slots::arrays * set_.stride, 0.0);
  scratch_.hull.assign(3 * set_.stride, 0.0);
  rows_.lagrange.assign(max_terms * rows_.stride, 0.0);
  rows_.dual.assign(max_terms * rows_.stride, 0.0);
  rows_.weight.assign(rows_.stride, 0.0);
  rows_.orthogonal.assign((max_terms + 6) * rows_.stride, 0.0);
  refinement_.stride = (room_.slots + 15) / 8 * 8;
  refinement_.given.assign(12 * refinement_.stride, 0.0);
  refinement_.misfit.assign(12 * refinement_.stride, 0.0);
  refinement_.correction.assign(3 * rows_.stride, 0.0);
  refinement_.last_correction.assign(3 * rows_.stride, 0.0);
  set_.living.reserve(room_.slots + DenseFactor::panel);
  scratch_.gathered.reserve(room_.slots);
  scratch_.sorted.reserve(room_.slots);
  scratch_.added.reserve(2 * room_.slots);
  set_.by_id.reserve(room_.slots + DenseFactor::panel);
  scratch_.index.reserve(factor_.row_capacity());
  scratch_.kept_rows.reserve(factor_.row_capacity());
  scratch_.moved.reserve(room_.slots + DenseFactor::panel);
}

void RbfFit::clear() {
  factor_.clear();
  std::fill_n(set_.array(Slots::in_use), set_.stride, 0.0);
  std::fill_n(set_.array(Slots::share), set_.stride, 0.0);
  set_.weighted = false;
  set_.slots = set_.alive = set_.dropped = 0;
  wear_.updated = wear_.worn = false;
  set_.by_id.clear();
}

void RbfFit::place(std::size_t slot, const Sample& sample) {
  const bool known = sample.stiffness.allFinite();
  set_.slot[slot] = {sample, true, level_.hermite && known, 0};
  set_.array(Slots::in_use)[slot] = sample.state ? 1 : 0;
  set_.array(Slots::share)[slot] = sample.state ? sample.weight : 0;
  set_.weighted = set_.weighted || sample.weighted;
  set_.array(Slots::force_norm)[slot] = set_.array(Slots::share)[slot] * sample.force.norm();
  set_.array(Slots::stiffness_norm)[slot] = known ? sample.stiffness.norm() : 0;
  for (std::size_t c = 0; c < 3; ++c) {
    set_.array(Slots::force + c)[slot] = sample.force[Eigen::Index(c)];
    for (std::size_t d = 0; d < 3; ++d)
      set_.array(Slots::stiffness + 3 * c + d)[slot] =
          known ? sample.stiffness(Eigen::Index(c), Eigen::Index(d)) : 0;
  }
  const Vec3 y = scaling_.scaled(sample.at);
  set_.px[slot] = y[0];
  set_.py[slot] = y[1];
  set_.pz[slot] = y[2];
  functionals(slot);
}

// l and v (polynomial.hpp) of the slot's rows.
void RbfFit::functionals(std::size_t slot) {
  const double y[3] = {set_.px[slot], set_.py[slot], set_.pz[slot]};
  double l[max_terms], gradient[3 * max_terms];
  lagrange(level_.degree, y, l, gradient);
  double phi[4][max_terms];  // of each row at each anchor
  for (std::size_t j = 0; j < rows_.terms; ++j) {
    const double d[3] = {y[0] - scaling_.anchors[j][0], y[1] - scaling_.anchors[j][1],
                         y[2] - scaling_.anchors[j][2]};
    const double r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    const double low = power(r2, level_.power - (level_.power > 1 ? 2 : 0));
    phi[0][j] = level_.power > 1 ? low * r2 : low;
    for (std::size_t t = 1; t < rows_.per_slot; ++t) phi[t][j] = level_.power * low * d[t - 1];
  }
  for (std::size_t t = 0; t < rows_.per_slot; ++t) {
    const std::size_t row = slot * rows_.per_slot + t;
    double lt[max_terms];
    for (std::size_t j = 0; j < rows_.terms; ++j) lt[j] = t == 0 ? l[j] : gradient[3 * j + t - 1];
    for (std::size_t j = 0; j < rows_.terms; ++j) {
      double v = 0;
      for (std::size_t k = 0; k < rows_.terms; ++k) v += scaling_.anchor_products[j * max_terms + k] * lt[k];
      rows_.lagrange[j * rows_.stride + row] = lt[j];
      rows_.dual[j * rows_.stride + row] = phi[t][j] - 0.5 * v;
    }
    rows_.weight[row] = t == 0 || set_.slot[slot].has_stiffness ? rows_.sign : 0;
  }
}

// Ridge on the diagonal of a functional: the user's, the least ridge of a set with weights, and a term for
// the weight w of its state. The last is (1 / w - 1) times the pivot of a state at the border of a lattice
// set of spacing h, so that the state counts with a share of about w.
double RbfFit::ridge(std::size_t slot, std::size_t functional) const {
  const double w = set_.slot[slot].sample.weight;
  const int k = level_.power - (functional > 0 ? 2 : 0);
  const double given =
      options_.ridge + (set_.weighted ? least_ridge(level_.power, level_.hermite, functional == 0) : 0);
  if (w >= 1) return given;
  const double h = (options_.length > 0 ? options_.length : 0.3 * scaling_.scale) * scaling_.inverse_scale *
                   set_.slot[slot].sample.reach;
  return given + border_pivot(level_.power, level_.hermite, functional == 0) * std::pow(h, k) * (1 / w - 1);
}

// The rows of up to eight plain or two Hermite slots.
void RbfFit::append_panel(std::size_t first_slot, std::size_t count) {
  const std::size_t b = rows_.per_slot, used = count * b;
  const std::size_t all = (first_slot + count) * b;
  assert(factor_.rows() == first_slot * b);
  double la[max_terms], va[max_terms];
  std::uint32_t skip = 0;
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t slot = first_slot + s;
    const double a[3] = {set_.px[slot], set_.py[slot], set_.pz[slot]};
    const Sample& sample = set_.slot[slot].sample;
    double* out = factor_.panel_row(s * b);
    if (b == 1)
      rows::loops().values(level_.power, first_slot + count, set_.px.data(), set_.py.data(), set_.pz.data(),
                           a, out);
    else
      rows::loops().hermite(level_.power, first_slot + count, set_.px.data(), set_.py.data(), set_.pz.data(),
                            a, out, factor_.panel_stride());
    for (std::size_t t = 0; t < b; ++t) {
      const std::size_t row = slot * b + t;
      double* line = factor_.panel_row(s * b + t);
      double* right = factor_.panel_border(s * b + t);
      for (std::size_t j = 0; j < rows_.terms; ++j) {
        right[j] = la[j] = rows_.lagrange[j * rows_.stride + row];
        va[j] = rows_.dual[j * rows_.stride + row];
      }
      rows::loops().project(rows_.terms, all, rows_.lagrange.data(), rows_.dual.data(), rows_.stride, la, va,
                            rows_.weight.data(), line);
      line[row] += ridge(slot, t);
      for (unsigned c = 0; c < 3; ++c)
        right[rows_.terms + c] =
            t == 0 ? sample.force[c] : -sample.stiffness(c, Eigen::Index(t) - 1) * scaling_.scale;
      for (std::size_t j = rows_.terms + 3; j < DenseFactor::border; ++j) right[j] = 0;
      if (t > 0 && !set_.slot[slot].has_stiffness) {
        skip |= 1u << (s * b + t);
        for (unsigned c = 0; c < 3; ++c) right[rows_.terms + c] = 0;
      }
    }
  }
  double tolerance[DenseFactor::panel] = {};
  for (std::size_t r = 0; r < used; ++r) tolerance[r] = pivot_tolerance(level_.power, b == 4, r % b == 0);
  const std::uint32_t taken = factor_.append(used, skip, tolerance);
  for (std::size_t s = 0; s < count; ++s) {
    const std::uint32_t mask = (1u << b) - 1;
    set_.slot[first_slot + s].dropped = ~(taken >> (s * b)) & ~(skip >> (s * b)) & mask;
    for (std::size_t t = 0; t < b; ++t)
      if ((set_.slot[first_slot + s].dropped >> t & 1u) != 0) rows_.weight[(first_slot + s) * b + t] = 0;
    set_.dropped += set_.slot[first_slot + s].dropped != 0 ? 1 : 0;
  }
}

void RbfFit::append(std::span<const Sample> added) {
  const std::size_t per_panel = rows_.per_slot == 1 ? 8 : 2;
  for (std::size_t i = 0; i < added.size(); i += per_panel) {
    const std::size_t count = std::min(per_panel, added.size() - i);
    for (std::size_t s = 0; s < count; ++s) {
      place(set_.slots + s, added[i + s]);
      enter(set_.slots + s);
    }
    append_panel(set_.slots, count);
    set_.slots += count;
    set_.alive += count;
  }
}

void RbfFit::refit(std::span<const Sample> samples) {
  assert(samples.size() <= room_.states);
  factorise(samples);
  if (!drops_matter()) return;
  // Which functionals are dropped depends on their order. Sorting by distance to the centre makes the choice
  // a function of the set.
  scratch_.sorted.assign(samples.begin(), samples.end());
  const Vec3 centre = scaling_.centre;
  std::ranges::sort(scratch_.sorted, [&](const Sample& a, const Sample& b) {
    const double da = (a.at - centre).squaredNorm(), db = (b.at - centre).squaredNorm();
    return da != db ? da < db : a.id < b.id;
  });
  factorise(scratch_.sorted);
}

// With r^5 and stiffness, what a near-duplicate adds is below rounding. Which of the duplicates is dropped
// must then not depend on the history of updates, so the set is factorised in a fixed order.
bool RbfFit::drops_matter() const {
  return set_.dropped > 0 && level_.hermite && level_.power == 5;
}

void RbfFit::factorise(std::span<const Sample> samples) {
  clear();
  if (samples.empty()) return;
  set_frame(samples);
  level_ = level_for(samples);
  rows_.per_slot = level_.hermite ? 4 : 1;
  rows_.terms = polynomial_terms(level_.degree);
  rows_.sign = level_.power == 3 ? 1 : -1;
  for (std::size_t j = 0; j < rows_.terms; ++j) scaling_.anchors[j] = anchor(j);
  for (std::size_t j = 0; j < rows_.terms; ++j)
    for (std::size_t k = 0; k < rows_.terms; ++k) {
      const auto &a = scaling_.anchors[j], &b = scaling_.anchors[k];
      double r2 = 0;
      for (std::size_t d = 0; d < 3; ++d) r2 += (a[d] - b[d]) * (a[d] - b[d]);
      scaling_.anchor_products[j * max_terms + k] = power(r2, level_.power);
    }
  append(samples);
}

}  // namespace forefeel
