// Replaces some of the states: finds the states to remove and to add, chooses update or refit, and compacts the factor.
#include <algorithm>

#include "approx/fit/rbf_fit.hpp"
#include "approx/loops/kernel_sums.hpp"

namespace forefeel {
using namespace detail;

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

// True if the anchors no longer suit the set: its centre or its size has changed much.
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

// Replacing more than this many of n states takes as long as a refit, or longer. Measured with stiffness at n
// = 25, 50 and 75: from 8, 12 and 16 states on for r^3, from 9, 14 and 17 for r^5.
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
    for (std::size_t s = 0; s < slots_; ++s) {  // a row dropped beside a removed state may count again
      if (!slot_[s].alive || slot_[s].dropped == 0) continue;
      added_.push_back(slot_[s].sample);
      leave(s);
    }
  std::ranges::sort(index_);
  std::erase_if(by_id_, [&](const Entry& e) { return slot_array(in_use)[e.slot] == 0; });
  added_.insert(added_.end(), added.begin(), added.end());
  // Holes cost as much as rows, so with four rows per state closing up pays soon.
  if ((b == 4 && 8 * (slots_ - alive_) > alive_) || slots_ + added_.size() > slot_capacity_)
    remove_and_close();
  else
    factor_.remove(index_);
  append(added_);
  if (drops_matter() || (mode_ == Mode::automatic && frame_expired())) return Outcome::stale;
  return level_still_fits() ? Outcome::done : Outcome::stale;
}

// Removes the rows of index_ and closes up all arrays.
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
