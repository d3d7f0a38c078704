// Finds the open candidate with the highest priority now. With many idle workers, only the best candidates are ranked
// again after each dispatch.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "scheduling/session/planner.hpp"

namespace forefeel {
namespace {

constexpr double highest = std::numeric_limits<double>::max();

}  // namespace

// Custom policies may return any number: priorities are sorted by <, NaN last. Negative and non-finite ones are counted
// and reported at the end.
double Planner::ranked_by(double priority) {
  priorities_refused_.not_numbers += std::isnan(priority);
  priorities_refused_.infinite += std::isinf(priority);
  priorities_refused_.negative += priority < 0 && std::isfinite(priority);
  return std::isnan(priority) ? -highest : std::clamp(priority, -highest, highest);
}

void Planner::predict(double now) {
  const bool truth = static_cast<bool>(hooks_.future);
  const double longest = truth ? std::clamp(0.3 + 3 * solve_seconds_, 0.3, 10.0)
                               : std::clamp(0.3 + 4 * solve_seconds_, 0.3, 3.0);
  const int steps = truth ? 24 : 8;
  predicted_.clear();
  for (int i = 0; i <= steps; ++i) {
    const double horizon = longest * i / steps;
    Prediction p = truth ? Prediction{.horizon = horizon, .at = hooks_.future(now + horizon), .deviation = 0}
                         : setup_.predictor->predict(horizon);
    p.horizon = horizon;
    predicted_.push_back(checked(p));
  }
}

// A NaN prediction is replaced by the present position of the hand; the number of such cases is reported at the end.
Prediction Planner::checked(Prediction p) {
  const bool somewhere = p.at.allFinite(), spread = p.deviation >= 0;
  if (!somewhere) p.at = hip_.at;
  if (!spread) p.deviation = 0;
  predictions_refused_ += !somewhere || !spread;
  return p;
}

PlannerView Planner::view(double now) const {
  return {.space = space_,
          .now = now,
          .hip = hip_,
          .predicted = predicted_,
          .solve_seconds = solve_seconds_ + 2 * setup_.latency,
          .workers = generator_.workers(),
          .pending = pending_,
          .with_stiffness = setup_.model.fit.data == Data::force_and_stiffness,
          .in_cells = setup_.model.method != SessionMethod::rbf,
          .surprises = surprises_};
}

void Planner::gather_pending(const Slot* but) {
  pending_.clear();
  for (const Slot& slot : slots_)
    if (!slot.cancelling && &slot != but)
      for (const Member& member : slot.members) pending_.push_back(member.candidate.at);
}

void Planner::look(double now) {
  predict(now);
  candidates_->follow(predicted_, now);
  candidates_->request_near(hip_.at, now);
  if (setup_.policy->reads_regions()) candidates_->refresh_regions();
  gather_pending(nullptr);
  setup_.policy->look(view(now));
}

void Planner::rank(double now) {
  const auto open = candidates_->open();
  priorities_.resize(open.size());
  setup_.policy->prioritise(open, view(now), priorities_);
  for (double& p : priorities_) p = ranked_by(p);
}

// Equal priorities are ordered by Candidate::order, so that the result is unique.
std::size_t Planner::best() const {
  const auto open = candidates_->open();
  std::size_t best = 0;
  for (std::size_t i = 1; i < open.size(); ++i)
    if (priorities_[i] != priorities_[best] ? priorities_[i] > priorities_[best]
                                            : open[i].order < open[best].order)
      best = i;
  return best;
}

void Planner::rank_for_many(double now) {
  rank(now);
  ranked_.clear();
  const auto open = candidates_->open();
  for (std::size_t i = 0; i < open.size(); ++i) ranked_.push_back({priorities_[i], open[i], pending_.size()});
  std::make_heap(ranked_.begin(), ranked_.end());
}

// The best open candidate, given that more jobs are pending now than when the heap was ranked. Priorities can
// only have fallen since, so the top of the heap is ranked again until one that is up to date stays on top.
std::size_t Planner::best_of_many(double now, double& priority) {
  constexpr std::size_t at_once = 8;
  std::vector<Candidate> again;
  std::vector<double> worth;
  for (;;) {
    again.clear();
    while (!ranked_.empty() && again.size() < at_once) {
      const Ranked top = ranked_.front();
      const bool as_now = top.pending == pending_.size();
      if (as_now && !again.empty()) break;
      std::pop_heap(ranked_.begin(), ranked_.end());
      ranked_.pop_back();
      const auto place = candidates_->index_of(top.candidate);
      if (!place) continue;
      if (!as_now) {
        again.push_back(top.candidate);
      } else if (setup_.policy->at_most(top.priority) == top.priority) {
        priority = top.priority;
        return *place;
      } else {
        break;  // others may be worth more by now
      }
    }
    if (again.empty()) {
      rank_for_many(now);
      const std::size_t place = best();
      priority = priorities_[place];
      return place;
    }
    worth.resize(again.size());
    setup_.policy->prioritise(again, view(now), worth);
    for (std::size_t i = 0; i < again.size(); ++i) {
      ranked_.push_back({ranked_by(worth[i]), again[i], pending_.size()});
      std::push_heap(ranked_.begin(), ranked_.end());
    }
  }
}

}  // namespace forefeel
