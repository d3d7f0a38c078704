#include "approx/fit/rbf_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "approx/loops/kernel_rows.hpp"
#include "approx/loops/kernel_sums.hpp"

namespace forefeel {
namespace {

// Pivots, relative to the diagonal, below which a row is a near-duplicate that rounding cannot tell from what
// is there. Two values a distance e apart count as e^2 (for r: e), two Hermite values as e^3 (r^3) or e^4
// (r^5); of the last the gradients beside them carry nearly all, so they go early.
double pivot_tolerance(int power, bool hermite, bool value) {
  if (!hermite) return 1e-15;
  return power == 5 && value ? 1e-11 : 1e-14;
}
// Ridge of a set with weights: in states far closer together than others no row is ever dropped, which would
// change at once what the rest makes of them, and rounding decides about nothing.
double least_ridge(int power, bool hermite, bool value) {
  return 10 * std::max(pivot_tolerance(power, hermite, value), 1e-14);
}
constexpr double rank_tolerance = 1e-6;  // pivot ratio of P below which a polynomial term is not determined

// Pivot of the last functional at the border of a lattice set, in units of h^k: medians over half balls.
double border_pivot(int power, bool hermite, bool value) {
  if (!hermite) return power == 5 ? 3 : 0.9;
  return value ? (power == 5 ? 1 : 0.6) : 2;
}

int power_of(Kernel kernel) {
  return kernel == Kernel::linear ? 1 : kernel == Kernel::cubic ? 3 : 5;
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

// Centre and scale so that the set fills the unit ball; in a set with weights what counts of it, so that a far
// state that hardly does changes neither which polynomial is determined nor what a ridge means.
void RbfFit::set_frame(std::span<const Sample> samples) {
  const bool weighted = samples[0].weighted;
  double total = 0, largest = 0;
  centre_.setZero();
  for (const auto& s : samples) {
    const double w = !weighted ? 1 : s.state ? s.weight : 0;
    total += w;
    centre_ += w * (s.at - samples[0].at);
  }
  centre_ = samples[0].at + centre_ / total;
  for (const auto& s : samples) {
    const double w = !weighted ? 1 : s.state ? s.weight : 0;
    largest = std::max(largest, w * (s.at - centre_).norm());
  }
  if (weighted) largest = std::max(largest, least_size * options_.length);
  scale_ = largest > 0 ? largest : options_.length > 0 ? options_.length : 1;
  inverse_scale_ = 1 / scale_;
}

namespace {

// The last pivot of a pivoted Cholesky is at least det / (product of the other diagonal entries), and the
// determinant needs no pivoting.
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

// The highest level whose polynomial the samples determine.
RbfFit::Level RbfFit::level_for(std::span<const Sample> samples) {
  Level level{power_of(options_.kernel), options_.kernel == Kernel::quintic ? 2 : 1,
              options_.data == Data::force_and_stiffness};
  // Places that carry the affine fit determine it, however little the set around them is.
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
      const Vec3 y = scaled(s.at);
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

// The same question for the level in use, from the rows that are there; a set that once stepped down is asked
// anew.
bool RbfFit::level_still_fits() {
  const int wanted = options_.kernel == Kernel::quintic ? 2 : 1;
  if (level_.degree == wanted) {
    double gram[max_terms * max_terms];
    std::fill_n(weight_.data() + slots_ * rows_per_slot_, 8, 0.0);
    dense::loops().gram(terms_, slots_ * rows_per_slot_, lagrange_.data(), row_stride_, weight_.data(), gram);
    return full_rank(terms_, gram);
  }
  gather();
  const Level level = level_for(gathered_);
  return level.power == level_.power && level.degree == level_.degree && level.hermite == level_.hermite;
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

// l and v of the slot's rows.
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

// On the diagonal of a functional: the user's, what keeps it from being dropped, and what its state's weight
// asks for. The last is about the
// pivot of a state at the border of a lattice set of spacing h times 1 / w - 1, so that w is about the share
// of it that counts.
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
  // Which functionals are dropped depends on their order; nearest to the centre first makes it the set's own.
  sorted_.assign(samples.begin(), samples.end());
  const Vec3 centre = centre_;
  std::ranges::sort(sorted_, [&](const Sample& a, const Sample& b) {
    const double da = (a.at - centre).squaredNorm(), db = (b.at - centre).squaredNorm();
    return da != db ? da < db : a.id < b.id;
  });
  factorise(sorted_);
}

// Between two Hermite states of r^5 so much is known already that what a near-duplicate adds is lost in
// rounding: a history of updates must not decide which of them count.
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

void RbfFit::difference(std::span<const StateId> wanted, std::vector<StateId>& removed,
                        std::vector<StateId>& missing) const {
  removed.clear();
  missing.clear();
  auto have = by_id_.begin();
  for (const StateId id : wanted) {
    for (; have != by_id_.end() && have->id < id; ++have) removed.push_back(have->id);
    if (have != by_id_.end() && have->id == id)
      ++have;
    else
      missing.push_back(id);
  }
  for (; have != by_id_.end(); ++have) removed.push_back(have->id);
}

void RbfFit::enter(std::size_t slot) {
  const Entry entry{slot_[slot].sample.id, static_cast<std::uint32_t>(slot)};
  by_id_.insert(std::ranges::upper_bound(by_id_, entry.id, {}, &Entry::id), entry);
}

void RbfFit::gather() {
  gathered_.clear();
  for (const Entry& e : by_id_) gathered_.push_back(slot_[e.slot].sample);
}

bool RbfFit::replace(std::span<const StateId> removed, std::span<const Sample> added) {
  const Outcome outcome = mode_ == Mode::refit ? Outcome::refused : try_update(removed, added);
  if (outcome == Outcome::done) return false;
  gather();
  if (outcome == Outcome::refused) {
    std::erase_if(gathered_,
                  [&](const Sample& s) { return std::ranges::find(removed, s.id) != removed.end(); });
    gathered_.insert(gathered_.end(), added.begin(), added.end());
  }
  added_.assign(gathered_.begin(), gathered_.end());
  refit(added_);
  return true;
}

// True where the anchors no longer suit the set: its centre or size has changed much.
bool RbfFit::frame_expired() {
  if (alive_ == 0) return true;
  double sums[5];
  sums::loops().extent(slots_, px_.data(), py_.data(), pz_.data(), slot_array(in_use), sums);
  const double mean = Vec3(sums[0], sums[1], sums[2]).squaredNorm() / double(alive_ * alive_);
  return sums[4] > 1.6 * 1.6 || sums[4] < 0.4 * 0.4 || mean > 0.5 * 0.5;
}

void RbfFit::leave(std::size_t slot) {
  dropped_slots_ -= slot_[slot].dropped != 0 ? 1 : 0;
  slot_[slot].alive = false;
  for (const std::size_t which : {in_use, share, force_norm, stiffness_norm}) slot_array(which)[slot] = 0;
  --alive_;
  for (std::size_t t = 0; t < rows_per_slot_; ++t) {
    index_.push_back(slot * rows_per_slot_ + t);
    weight_[index_.back()] = 0;
  }
}

namespace {

// Measured: an update of more of n states than this costs as much as a refit or more. With stiffness at n =
// 25, 50 and 75 from 8, 12 and 16 states on for r^3, from 9, 14 and 17 for r^5.
double most_updated(double n, bool hermite) {
  return hermite ? std::min(4 + 0.15 * n, 0.5 * n) : 2 + 0.2 * n;
}

}  // namespace

RbfFit::Outcome RbfFit::try_update(std::span<const StateId> removed, std::span<const Sample> added) {
  const std::size_t b = rows_per_slot_, changed = (removed.size() + added.size()) / 2;
  if (alive_ == 0 || alive_ + added.size() < removed.size() + 1) return Outcome::refused;
  if (mode_ == Mode::automatic && worn_) return Outcome::refused;
  if (mode_ == Mode::automatic && double(changed) > most_updated(double(alive_), b == 4))
    return Outcome::refused;

  updated_ = true;
  added_.clear();
  index_.clear();
  for (const StateId id : removed) leave(std::ranges::lower_bound(by_id_, id, {}, &Entry::id)->slot);
  if (dropped_slots_ > 0 && !removed.empty())
    for (std::size_t s = 0; s < slots_; ++s) {  // what was dropped beside a state that left may count again
      if (!slot_[s].alive || slot_[s].dropped == 0) continue;
      added_.push_back(slot_[s].sample);
      leave(s);
    }
  std::ranges::sort(index_);
  std::erase_if(by_id_, [&](const Entry& e) { return slot_array(in_use)[e.slot] == 0; });
  added_.insert(added_.end(), added.begin(), added.end());
  // Holes cost as much as rows: where four go with a state, closing up soon pays.
  if ((b == 4 && 8 * (slots_ - alive_) > alive_) || slots_ + added_.size() > slot_capacity_)
    remove_and_close();
  else
    factor_.remove(index_);
  append(added_);
  if (drops_matter() || (mode_ == Mode::automatic && frame_expired())) return Outcome::stale;
  return level_still_fits() ? Outcome::done : Outcome::stale;
}

// Takes the rows of index_ out and moves all arrays together.
void RbfFit::remove_and_close() {
  const std::size_t b = rows_per_slot_;
  std::size_t first = 0;  // slots before it stay
  while (first < slots_ && slot_[first].alive) ++first;
  kept_rows_.clear();
  moved_.clear();
  for (std::size_t s = 0; s < slots_; ++s) {
    moved_.push_back(static_cast<std::uint32_t>(kept_rows_.size() / b));
    if (!slot_[s].alive) continue;
    if (s > first) slot_[moved_[s]] = slot_[s];
    for (std::size_t t = 0; t < b; ++t) kept_rows_.push_back(s * b + t);
  }
  const std::size_t kept = kept_rows_.size() / b;
  for (Entry& e : by_id_) e.slot = moved_[e.slot];
  const auto gather = [&](double* values, std::size_t step) {
    if (step == 4)
      for (std::size_t i = first; i < kept; ++i) {
        const double* from = values + kept_rows_[4 * i];
        const double row[4] = {from[0], from[1], from[2], from[3]};
        for (std::size_t t = 0; t < 4; ++t) values[4 * i + t] = row[t];
      }
    else
      for (std::size_t i = first; i < kept; ++i) values[i] = values[kept_rows_[b * i] / b];
  };
  for (AlignedArray* p : {&px_, &py_, &pz_}) gather(p->data(), 1);
  for (std::size_t which = 0; which < away; ++which) gather(slot_array(which), 1);
  gather(weight_.data(), b);
  for (std::size_t j = 0; j < terms_; ++j) {
    gather(lagrange_.data() + j * row_stride_, b);
    gather(dual_.data() + j * row_stride_, b);
  }
  factor_.remove(index_, kept_rows_);
  for (const std::size_t which : {in_use, share})
    std::fill(slot_array(which) + kept, slot_array(which) + slots_, 0.0);
  slots_ = kept;
}

}  // namespace forefeel
