#include "approx/fit/rbf_fit.hpp"

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
    : options_(options), capacity_(std::max<std::size_t>(capacity, 1)) {
  const bool hermite = options.data == Data::force_and_stiffness;
  const std::size_t rows = hermite ? 4 : 1;
  slot_capacity_ = capacity_ + std::max<std::size_t>(hermite ? 8 : 32, capacity_ / 8) + DenseFactor::panel;
  factor_ = DenseFactor(rows * slot_capacity_ + DenseFactor::panel);
  slot_.resize(slot_capacity_ + DenseFactor::panel);
  row_stride_ = (factor_.row_capacity() + 23) / 8 * 8;
  for (auto* v : {&px_, &py_, &pz_}) v->assign(slot_capacity_ + 2 * DenseFactor::panel, 0.0);
  slot_stride_ = (slot_capacity_ + 2 * DenseFactor::panel + 7) / 8 * 8;
  slot_data_.assign(slot_arrays * slot_stride_, 0.0);
  hull_.assign(3 * slot_stride_, 0.0);
  lagrange_.assign(max_terms * row_stride_, 0.0);
  dual_.assign(max_terms * row_stride_, 0.0);
  weight_.assign(row_stride_, 0.0);
  orthogonal_.assign((max_terms + 6) * row_stride_, 0.0);
  given_stride_ = (slot_capacity_ + 15) / 8 * 8;
  given_.assign(12 * given_stride_, 0.0);
  misfit_.assign(12 * given_stride_, 0.0);
  correction_.assign(3 * row_stride_, 0.0);
  last_correction_.assign(3 * row_stride_, 0.0);
  living_.reserve(slot_capacity_ + DenseFactor::panel);
  gathered_.reserve(slot_capacity_);
  sorted_.reserve(slot_capacity_);
  added_.reserve(2 * slot_capacity_);
  by_id_.reserve(slot_capacity_ + DenseFactor::panel);
  index_.reserve(factor_.row_capacity());
  kept_rows_.reserve(factor_.row_capacity());
  moved_.reserve(slot_capacity_ + DenseFactor::panel);
}

void RbfFit::clear() {
  factor_.clear();
  std::fill_n(slot_array(in_use), slot_stride_, 0.0);
  std::fill_n(slot_array(share), slot_stride_, 0.0);
  weighted_ = false;
  slots_ = alive_ = dropped_slots_ = 0;
  updated_ = worn_ = false;
  by_id_.clear();
}

void RbfFit::place(std::size_t slot, const Sample& sample) {
  const bool known = sample.stiffness.allFinite();
  slot_[slot] = {sample, true, level_.hermite && known, 0};
  slot_array(in_use)[slot] = sample.state ? 1 : 0;
  slot_array(share)[slot] = sample.state ? sample.weight : 0;
  weighted_ = weighted_ || sample.weighted;
  slot_array(force_norm)[slot] = slot_array(share)[slot] * sample.force.norm();
  slot_array(stiffness_norm)[slot] = known ? sample.stiffness.norm() : 0;
  for (std::size_t c = 0; c < 3; ++c) {
    slot_array(force + c)[slot] = sample.force[Eigen::Index(c)];
    for (std::size_t d = 0; d < 3; ++d)
      slot_array(stiffness + 3 * c + d)[slot] =
          known ? sample.stiffness(Eigen::Index(c), Eigen::Index(d)) : 0;
  }
  const Vec3 y = scaled(sample.at);
  px_[slot] = y[0];
  py_[slot] = y[1];
  pz_[slot] = y[2];
  functionals(slot);
}

// l and v (polynomial.hpp) of the slot's rows.
void RbfFit::functionals(std::size_t slot) {
  const double y[3] = {px_[slot], py_[slot], pz_[slot]};
  double l[max_terms], gradient[3 * max_terms];
  lagrange(level_.degree, y, l, gradient);
  double phi[4][max_terms];  // of each row at each anchor
  for (std::size_t j = 0; j < terms_; ++j) {
    const double d[3] = {y[0] - anchors_[j][0], y[1] - anchors_[j][1], y[2] - anchors_[j][2]};
    const double r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    const double low = power(r2, level_.power - (level_.power > 1 ? 2 : 0));
    phi[0][j] = level_.power > 1 ? low * r2 : low;
    for (std::size_t t = 1; t < rows_per_slot_; ++t) phi[t][j] = level_.power * low * d[t - 1];
  }
  for (std::size_t t = 0; t < rows_per_slot_; ++t) {
    const std::size_t row = slot * rows_per_slot_ + t;
    double lt[max_terms];
    for (std::size_t j = 0; j < terms_; ++j) lt[j] = t == 0 ? l[j] : gradient[3 * j + t - 1];
    for (std::size_t j = 0; j < terms_; ++j) {
      double v = 0;
      for (std::size_t k = 0; k < terms_; ++k) v += anchor_products_[j * max_terms + k] * lt[k];
      lagrange_[j * row_stride_ + row] = lt[j];
      dual_[j * row_stride_ + row] = phi[t][j] - 0.5 * v;
    }
    weight_[row] = t == 0 || slot_[slot].has_stiffness ? sign_ : 0;
  }
}

// Ridge on the diagonal of a functional: the user's, the least ridge of a set with weights, and a term for
// the weight w of its state. The last is (1 / w - 1) times the pivot of a state at the border of a lattice
// set of spacing h, so that the state counts with a share of about w.
double RbfFit::ridge(std::size_t slot, std::size_t functional) const {
  const double w = slot_[slot].sample.weight;
  const int k = level_.power - (functional > 0 ? 2 : 0);
  const double given =
      options_.ridge + (weighted_ ? least_ridge(level_.power, level_.hermite, functional == 0) : 0);
  if (w >= 1) return given;
  const double h =
      (options_.length > 0 ? options_.length : 0.3 * scale_) * inverse_scale_ * slot_[slot].sample.reach;
  return given + border_pivot(level_.power, level_.hermite, functional == 0) * std::pow(h, k) * (1 / w - 1);
}

// The rows of up to eight plain or two Hermite slots.
void RbfFit::append_panel(std::size_t first_slot, std::size_t count) {
  const std::size_t b = rows_per_slot_, used = count * b;
  const std::size_t all = (first_slot + count) * b;
  assert(factor_.rows() == first_slot * b);
  double la[max_terms], va[max_terms];
  std::uint32_t skip = 0;
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t slot = first_slot + s;
    const double a[3] = {px_[slot], py_[slot], pz_[slot]};
    const Sample& sample = slot_[slot].sample;
    double* out = factor_.panel_row(s * b);
    if (b == 1)
      rows::loops().values(level_.power, first_slot + count, px_.data(), py_.data(), pz_.data(), a, out);
    else
      rows::loops().hermite(level_.power, first_slot + count, px_.data(), py_.data(), pz_.data(), a, out,
                            factor_.panel_stride());
    for (std::size_t t = 0; t < b; ++t) {
      const std::size_t row = slot * b + t;
      double* line = factor_.panel_row(s * b + t);
      double* right = factor_.panel_border(s * b + t);
      for (std::size_t j = 0; j < terms_; ++j) {
        right[j] = la[j] = lagrange_[j * row_stride_ + row];
        va[j] = dual_[j * row_stride_ + row];
      }
      rows::loops().project(terms_, all, lagrange_.data(), dual_.data(), row_stride_, la, va, weight_.data(),
                            line);
      line[row] += ridge(slot, t);
      for (int c = 0; c < 3; ++c)
        right[terms_ + c] = t == 0 ? sample.force[c] : -sample.stiffness(c, Eigen::Index(t) - 1) * scale_;
      for (std::size_t j = terms_ + 3; j < DenseFactor::border; ++j) right[j] = 0;
      if (t > 0 && !slot_[slot].has_stiffness) {
        skip |= 1u << (s * b + t);
        for (int c = 0; c < 3; ++c) right[terms_ + c] = 0;
      }
    }
  }
  double tolerance[DenseFactor::panel] = {};
  for (std::size_t r = 0; r < used; ++r) tolerance[r] = pivot_tolerance(level_.power, b == 4, r % b == 0);
  const std::uint32_t taken = factor_.append(used, skip, tolerance);
  for (std::size_t s = 0; s < count; ++s) {
    const std::uint32_t mask = (1u << b) - 1;
    slot_[first_slot + s].dropped = ~(taken >> (s * b)) & ~(skip >> (s * b)) & mask;
    for (std::size_t t = 0; t < b; ++t)
      if ((slot_[first_slot + s].dropped >> t & 1u) != 0) weight_[(first_slot + s) * b + t] = 0;
    dropped_slots_ += slot_[first_slot + s].dropped != 0 ? 1 : 0;
  }
}

void RbfFit::append(std::span<const Sample> added) {
  const std::size_t per_panel = rows_per_slot_ == 1 ? 8 : 2;
  for (std::size_t i = 0; i < added.size(); i += per_panel) {
    const std::size_t count = std::min(per_panel, added.size() - i);
    for (std::size_t s = 0; s < count; ++s) {
      place(slots_ + s, added[i + s]);
      enter(slots_ + s);
    }
    append_panel(slots_, count);
    slots_ += count;
    alive_ += count;
  }
}

void RbfFit::refit(std::span<const Sample> samples) {
  assert(samples.size() <= capacity_);
  factorise(samples);
  if (!drops_matter()) return;
  // Which functionals are dropped depends on their order. Sorting by distance to the centre makes the choice
  // a function of the set.
  sorted_.assign(samples.begin(), samples.end());
  const Vec3 centre = centre_;
  std::ranges::sort(sorted_, [&](const Sample& a, const Sample& b) {
    const double da = (a.at - centre).squaredNorm(), db = (b.at - centre).squaredNorm();
    return da != db ? da < db : a.id < b.id;
  });
  factorise(sorted_);
}

// With r^5 and stiffness, what a near-duplicate adds is below rounding. Which of the duplicates is dropped
// must then not depend on the history of updates, so the set is factorised in a fixed order.
bool RbfFit::drops_matter() const {
  return dropped_slots_ > 0 && level_.hermite && level_.power == 5;
}

void RbfFit::factorise(std::span<const Sample> samples) {
  clear();
  if (samples.empty()) return;
  set_frame(samples);
  level_ = level_for(samples);
  rows_per_slot_ = level_.hermite ? 4 : 1;
  terms_ = polynomial_terms(level_.degree);
  sign_ = level_.power == 3 ? 1 : -1;
  for (std::size_t j = 0; j < terms_; ++j) anchors_[j] = anchor(j);
  for (std::size_t j = 0; j < terms_; ++j)
    for (std::size_t k = 0; k < terms_; ++k) {
      const auto &a = anchors_[j], &b = anchors_[k];
      double r2 = 0;
      for (int d = 0; d < 3; ++d) r2 += (a[d] - b[d]) * (a[d] - b[d]);
      anchor_products_[j * max_terms + k] = power(r2, level_.power);
    }
  append(samples);
}

}  // namespace forefeel
