// Replaces some of the states: finds the states to remove and to add, chooses update or refit, and compacts the factor.
#include <algorithm>

#include "approx/loops/kernel_sums.hpp"
#include "approx/model/rbf_fit.hpp"

namespace forefeel {
using namespace detail;

void RbfFit::difference(std::span<const StateId> wanted, std::vector<StateId>& removed,
                        std::vector<StateId>& missing) const {
  removed.clear();
  missing.clear();
  auto have = set_.by_id.begin();
  for (const StateId id : wanted) {
    for (; have != set_.by_id.end() && have->id < id; ++have) removed.push_back(have->id);
    if (have != set_.by_id.end() && have->id == id)
      ++have;
    else
      missing.push_back(id);
  }
  for (; have != set_.by_id.end(); ++have) removed.push_back(have->id);
}

void RbfFit::enter(std::size_t slot) {
  const Entry entry{set_.slot[slot].sample.id, static_cast<std::uint32_t>(slot)};
  set_.by_id.insert(std::ranges::upper_bound(set_.by_id, entry.id, {}, &Entry::id), entry);
}

void RbfFit::gather() {
  scratch_.gathered.clear();
  for (const Entry& e : set_.by_id) scratch_.gathered.push_back(set_.slot[e.slot].sample);
}

bool RbfFit::replace(std::span<const StateId> removed, std::span<const Sample> added) {
  const Outcome outcome = mode_ == Mode::refit ? Outcome::refused : try_update(removed, added);
  if (outcome == Outcome::done) return false;
  gather();
  if (outcome == Outcome::refused) {
    std::erase_if(scratch_.gathered,
                  [&](const Sample& s) { return std::ranges::find(removed, s.id) != removed.end(); });
    scratch_.gathered.insert(scratch_.gathered.end(), added.begin(), added.end());
  }
  scratch_.added.assign(scratch_.gathered.begin(), scratch_.gathered.end());
  refit(scratch_.added);
  return true;
}

// True if the anchors no longer suit the set: its centre or its size has changed much.
bool RbfFit::frame_expired() {
  if (set_.alive == 0) return true;
  double sums[5];
  sums::loops().extent(set_.slots, set_.px.data(), set_.py.data(), set_.pz.data(), set_.array(Slots::in_use),
                       sums);
  const double mean = Vec3(sums[0], sums[1], sums[2]).squaredNorm() / double(set_.alive * set_.alive);
  return sums[4] > 1.6 * 1.6 || sums[4] < 0.4 * 0.4 || mean > 0.5 * 0.5;
}

void RbfFit::leave(std::size_t slot) {
  set_.dropped -= set_.slot[slot].dropped != 0 ? 1 : 0;
  set_.slot[slot].alive = false;
  for (const std::size_t which : {Slots::in_use, Slots::share, Slots::force_norm, Slots::stiffness_norm})
    set_.array(which)[slot] = 0;
  --set_.alive;
  for (std::size_t t = 0; t < rows_.per_slot; ++t) {
    scratch_.index.push_back(slot * rows_.per_slot + t);
    rows_.weight[scratch_.index.back()] = 0;
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
  const std::size_t b = rows_.per_slot, changed = (removed.size() + added.size()) / 2;
  if (set_.alive == 0 || set_.alive + added.size() < removed.size() + 1) return Outcome::refused;
  if (mode_ == Mode::automatic && wear_.worn) return Outcome::refused;
  if (mode_ == Mode::automatic && double(changed) > most_updated(double(set_.alive), b == 4))
    return Outcome::refused;

  wear_.updated = true;
  scratch_.added.clear();
  scratch_.index.clear();
  for (const StateId id : removed) leave(std::ranges::lower_bound(set_.by_id, id, {}, &Entry::id)->slot);
  if (set_.dropped > 0 && !removed.empty())
    for (std::size_t s = 0; s < set_.slots; ++s) {  // a row dropped beside a removed state may count again
      if (!set_.slot[s].alive || set_.slot[s].dropped == 0) continue;
      scratch_.added.push_back(set_.slot[s].sample);
      leave(s);
    }
  std::ranges::sort(scratch_.index);
  std::erase_if(set_.by_id, [&](const Entry& e) { return set_.array(Slots::in_use)[e.slot] == 0; });
  scratch_.added.insert(scratch_.added.end(), added.begin(), added.end());
  // Holes cost as much as rows, so with four rows per state closing up pays soon.
  if ((b == 4 && 8 * (set_.slots - set_.alive) > set_.alive) ||
      set_.slots + scratch_.added.size() > room_.slots)
    remove_and_close();
  else
    factor_.remove(scratch_.index);
  append(scratch_.added);
  if (drops_matter() || (mode_ == Mode::automatic && frame_expired())) return Outcome::stale;
  return level_still_fits() ? Outcome::done : Outcome::stale;
}

// Removes the rows of scratch_.index and closes up all arrays.
void RbfFit::remove_and_close() {
  const std::size_t b = rows_.per_slot;
  std::size_t first = 0;  // slots before it stay
  while (first < set_.slots && set_.slot[first].alive) ++first;
  scratch_.kept_rows.clear();
  scratch_.moved.clear();
  for (std::size_t s = 0; s < set_.slots; ++s) {
    scratch_.moved.push_back(static_cast<std::uint32_t>(scratch_.kept_rows.size() / b));
    if (!set_.slot[s].alive) continue;
    if (s > first) set_.slot[scratch_.moved[s]] = set_.slot[s];
    for (std::size_t t = 0; t < b; ++t) scratch_.kept_rows.push_back(s * b + t);
  }
  const std::size_t kept = scratch_.kept_rows.size() / b;
  for (Entry& e : set_.by_id) e.slot = scratch_.moved[e.slot];
  const auto gather = [&](double* values, std::size_t step) {
    if (step == 4)
      for (std::size_t i = first; i < kept; ++i) {
        const double* from = values + scratch_.kept_rows[4 * i];
        const double row[4] = {from[0], from[1], from[2], from[3]};
        for (std::size_t t = 0; t < 4; ++t) values[4 * i + t] = row[t];
      }
    else
      for (std::size_t i = first; i < kept; ++i) values[i] = values[scratch_.kept_rows[b * i] / b];
  };
  for (AlignedArray* p : {&set_.px, &set_.py, &set_.pz}) gather(p->data(), 1);
  for (std::size_t which = 0; which < Slots::away; ++which) gather(set_.array(which), 1);
  gather(rows_.weight.data(), b);
  for (std::size_t j = 0; j < rows_.terms; ++j) {
    gather(rows_.lagrange.data() + j * rows_.stride, b);
    gather(rows_.dual.data() + j * rows_.stride, b);
  }
  factor_.remove(scratch_.index, scratch_.kept_rows);
  for (const std::size_t which : {Slots::in_use, Slots::share})
    std::fill(set_.array(which) + kept, set_.array(which) + set_.slots, 0.0);
  set_.slots = kept;
}

}  // namespace forefeel
