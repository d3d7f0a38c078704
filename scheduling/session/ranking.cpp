#include "scheduling/session/ranking.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "scheduling/touch/site_candidates.hpp"

namespace forefeel {
namespace {

constexpr double highest = std::numeric_limits<double>::max();

std::vector<State> failed_of(std::span<const State> states) {
  std::vector<State> failed;
  for (const State& state : states)
    if (!state.usable()) failed.push_back(state);
  return failed;
}

std::unique_ptr<Candidates> candidates_of(const PlannerSetup& setup, const StateSpace& space) {
  if (setup.surface) return std::make_unique<SiteCandidates>(space, *setup.surface);
  return std::make_unique<LatticeCandidates>(space, failed_of(setup.known), setup.options.placement);
}

}  // namespace

Ranking::Ranking(const PlannerSetup& setup, const StateSpace& space, std::function<Vec3(double)> future)
    : setup_(setup),
      space_(space),
      future_(std::move(future)),
      candidates_(candidates_of(setup, space)),
      estimate_(candidates_->estimate()) {}

// Custom policies may return any number: priorities are sorted by <, NaN last. Negative and non-finite ones are counted
// and reported at the end.
double Ranking::ranked_by(double priority) {
  refused_.not_numbers += std::isnan(priority);
  refused_.infinite += std::isinf(priority);
  refused_.negative += priority < 0 && std::isfinite(priority);
  return std::isnan(priority) ? -highest : std::clamp(priority, -highest, highest);
}

void Ranking::predict() {
  const bool truth = static_cast<bool>(future_);
  const double solve = moment_.solve_seconds;
  const double longest =
      truth ? std::clamp(0.3 + 3 * solve, 0.3, 10.0) : std::clamp(0.3 + 4 * solve, 0.3, 3.0);
  const int steps = truth ? 24 : 8;
  predicted_.clear();
  for (int i = 0; i <= steps; ++i) {
    const double horizon = longest * i / steps;
    Prediction p = truth
                       ? Prediction{.horizon = horizon, .at = future_(moment_.now + horizon), .deviation = 0}
                       : setup_.predictor->predict(horizon);
    p.horizon = horizon;
    predicted_.push_back(checked(p));
  }
}

// A NaN prediction is replaced by the present position of the hand; the number of such cases is reported at the end.
Prediction Ranking::checked(Prediction p) {
  const bool somewhere = p.at.allFinite(), spread = p.deviation >= 0;
  if (!somewhere) p.at = moment_.hip.at;
  if (!spread) p.deviation = 0;
  refused_.predictions += !somewhere || !spread;
  return p;
}

PlannerView Ranking::view() const {
  return {.space = space_,
          .now = moment_.now,
          .hip = moment_.hip,
          .predicted = predicted_,
          .solve_seconds = moment_.solve_seconds + 2 * setup_.latency,
          .workers = moment_.workers,
          .pending = pending_,
          .with_stiffness = setup_.model.fit.data != Data::force,
          .in_cells = setup_.model.method != SessionMethod::rbf,
          .surprises = moment_.surprises,
          .estimate = estimate_ ? estimate_ : moment_.estimate};
}

void Ranking::look(const PlanMoment& moment, std::vector<Vec3> pending) {
  moment_ = moment;
  predict();
  candidates_->follow(predicted_, moment.hip, moment.now);
  candidates_->request_near(moment.hip.at, moment.now);
  if (setup_.policy->reads_regions()) candidates_->refresh_regions();
  pending_ = std::move(pending);
  setup_.policy->look(view());
}

void Ranking::pend(std::vector<Vec3> pending) {
  pending_ = std::move(pending);
  tell();
}

void Ranking::tell() {
  setup_.policy->pend(view());
}

double Ranking::worth(const Candidate& candidate) {
  return ranked_by(setup_.policy->priority(candidate, view()));
}

void Ranking::rank() {
  const auto open = candidates_->open();
  priorities_.resize(open.size());
  setup_.policy->prioritise(open, view(), priorities_);
  for (double& p : priorities_) p = ranked_by(p);
}

// Equal priorities are ordered by Candidate::order, so that the result is unique.
std::size_t Ranking::first() const {
  const auto open = candidates_->open();
  std::size_t best = 0;
  for (std::size_t i = 1; i < open.size(); ++i)
    if (priorities_[i] != priorities_[best] ? priorities_[i] > priorities_[best]
                                            : open[i].order < open[best].order)
      best = i;
  return best;
}

Ranking::Chosen Ranking::best() {
  rank();
  const std::size_t place = first();
  return {.place = place, .priority = priorities_[place]};
}

std::vector<Candidate> Ranking::beside(std::size_t place) const {
  std::vector<std::pair<double, Candidate>> near;
  const auto open = candidates_->open();
  for (std::size_t i = 0; i < open.size(); ++i)
    if (i != place && !open[i].passing &&
        (open[i].at - open[place].at).norm() <= 1.1 * space_.options().spacing)
      near.emplace_back(priorities_[i], open[i]);
  std::ranges::sort(near, [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second.order < b.second.order;
  });
  std::vector<Candidate> sorted;
  for (const auto& [priority, candidate] : near) sorted.push_back(candidate);
  return sorted;
}

bool Ranking::ranks_many() const {
  return std::isfinite(setup_.policy->at_most(1));
}

void Ranking::begin_many() {
  rank();
  ranked_.clear();
  const auto open = candidates_->open();
  for (std::size_t i = 0; i < open.size(); ++i) ranked_.push_back({priorities_[i], open[i], pending_.size()});
  std::make_heap(ranked_.begin(), ranked_.end());
}

// Given that more jobs are pending now than when the heap was ranked. Priorities can only have fallen since, so the top
// of the heap is ranked again until one that is up to date stays on top.
Ranking::Chosen Ranking::best_of_many() {
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
        return {.place = *place, .priority = top.priority};
      } else {
        break;  // others may be worth more by now
      }
    }
    if (again.empty()) {
      begin_many();
      const std::size_t place = first();
      return {.place = place, .priority = priorities_[place]};
    }
    worth.resize(again.size());
    setup_.policy->prioritise(again, view(), worth);
    for (std::size_t i = 0; i < again.size(); ++i) {
      ranked_.push_back({ranked_by(worth[i]), again[i], pending_.size()});
      std::push_heap(ranked_.begin(), ranked_.end());
    }
  }
}

std::vector<std::string> Ranking::complaints() const {
  std::vector<std::string> lines;
  if (refused_.not_numbers + refused_.infinite + refused_.negative > 0)
    lines.push_back(
        fmt::format("policy {} gave priorities that are not finite numbers of at least 0: {} not numbers, {} "
                    "infinite, {} negative; they were sorted by <, NaN last",
                    setup_.policy->name(), refused_.not_numbers, refused_.infinite, refused_.negative));
  if (refused_.predictions > 0)
    lines.push_back(fmt::format(
        "the predictor gave {} positions that are not finite or deviations that are not at least 0: the hand "
        "counted as staying where it was, the deviation as 0",
        refused_.predictions));
  return lines;
}

}  // namespace forefeel
