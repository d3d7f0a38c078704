#include "scheduling/touch/touch_planner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

constexpr double jets_apart = 0.25;  // of site_spacing
constexpr int predictions = 8;
constexpr double trust_factor = 3;  // that of DeepStates::trusted()

}  // namespace

TouchPlanner::TouchPlanner(TouchTask task, TouchPlannerParts parts, std::vector<State> known)
    : task_(std::move(task)),
      parts_(std::move(parts)),
      field_(task_.field, task_.grid, farthest_of(task_.depth), task_.patches),
      tips_(task_.tips) {
  for (std::size_t i = 0; i < task_.field->size(); ++i) {
    if (!task_.patches) jets_.push_back(task_.field->place(i));
    State at_rest;
    at_rest.at = task_.field->place(i).at;
    tips_.insert(std::move(at_rest));
  }
  for (const State& state : known) learn(state);
  models_.push_back(std::make_unique<TouchModel>(
      TouchModel{.serial = 1,
                 .known = 0,
                 .deep = std::make_shared<const DeepStates>(task_.field, DeepOptions{}, task_.patches)}));
  model();
}

void TouchPlanner::learn(const State& state) {
  if (!state.usable() || !state.has_site()) return;
  State tip;
  tip.at = state.site + state.at;
  tip.solve.status = state.solve.status;
  tips_.insert(std::move(tip));
  if (state.at.isZero(0)) jets_.push_back(task_.field->rest().map().nearest(state.site));
  known_.push_back(state);
  fresh_.push_back(state);
}

void TouchPlanner::observe(const TouchSeen& seen) {
  seen_ = seen;
  parts_.predictor->observe(seen.tip);
}

void TouchPlanner::predict() {
  const double solve = times_.empty() ? parts_.solve_seconds : median(times_);
  const double longest = std::clamp(0.3 + 4 * solve, 0.3, 3.0);
  predicted_.clear();
  for (int i = 0; i <= predictions; ++i) {
    const double horizon = longest * i / predictions;
    Prediction p = parts_.future ? Prediction{.at = parts_.future(seen_.tip.t + horizon), .deviation = 0}
                                 : parts_.predictor->predict(horizon);
    p.horizon = horizon;
    if (!p.at.allFinite()) p.at = seen_.tip.at;
    if (!(p.deviation >= 0)) p.deviation = 0;
    predicted_.push_back(p);
  }
}

// Where the tip will press. Without friction a touch keeps its site; with it, the site is taken to follow the tip.
std::vector<TouchPlanner::Visit> TouchPlanner::visits() const {
  std::vector<Visit> visits;
  std::optional<SurfacePlace> site;
  if (seen_.touching) site = seen_.site;
  Vec3 before = seen_.tip.at;
  for (const Prediction& p : predicted_) {
    const bool inside = task_.grid->inside(p.at);
    if (!inside) {
      site.reset();
    } else if (!site) {
      site = task_.grid->crossing(before, p.at);
      if (!site) site = task_.field->rest().map().nearest(p.at);
    } else if (task_.friction) {
      const SurfacePlace under = task_.field->rest().map().nearest(p.at);
      const Vec3 x = p.at - site->at;
      // A site is dragged where the tip leans over by more than the cone allows.
      if ((under.at - site->at).norm() > *task_.friction * x.norm()) site = under;
    }
    if (site && !task_.field->rest().map().facet(*site).clamped) visits.push_back({*site, p.at - site->at});
    before = p.at;
  }
  return visits;
}

bool TouchPlanner::near_jet(const SurfacePlace& site) const {
  const double apart = jets_apart * task_.field->options().spacing;
  return std::ranges::any_of(
      jets_, [&](const SurfacePlace& jet) { return (jet.at - site.at).squaredNorm() < apart * apart; });
}

std::optional<SurfacePlace> TouchPlanner::missing_jet(const std::vector<Visit>& visits) const {
  for (const Visit& visit : visits)
    if (!near_jet(visit.site)) return visit.site;
  return {};
}

TouchPlanner::Key TouchPlanner::key_of(const SurfacePlace& site, const Vec3& tip) const {
  Key key;
  for (Eigen::Index i = 0; i < 3; ++i) {
    key[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(std::lround(tip[i] / task_.tips.spacing));
    key[static_cast<std::size_t>(i) + 3] =
        static_cast<std::int32_t>(std::lround(2 * site.at[i] / task_.field->options().spacing));
  }
  return key;
}

// 0 <= -x . n <= depth, and |x_t| at most half of it.
bool TouchPlanner::in_region(const Visit& visit, const Vec3& normal) const {
  const double deep = -visit.x.dot(normal);
  return deep >= 0 && deep <= task_.depth && (visit.x + deep * normal).norm() <= 0.5 * task_.depth;
}

std::vector<TouchPlanner::Wanted> TouchPlanner::candidates(const std::vector<Visit>& visits, double now) {
  const double h = task_.tips.spacing;
  std::map<Key, Wanted> found;
  for (const Visit& visit : visits) {
    const Vec3 middle = (visit.site.at + visit.x) / h;
    for (int ix = -1; ix <= 1; ++ix)
      for (int iy = -1; iy <= 1; ++iy)
        for (int iz = -1; iz <= 1; ++iz) {
          const Vec3 tip = h * (middle.array().round().matrix() + Vec3(ix, iy, iz));
          const Key key = key_of(visit.site, tip);
          if (gone_.contains(key) || found.contains(key)) continue;
          const Visit at{visit.site, tip - visit.site.at};
          const TouchTerms terms = field_.at(at.site, at.x, false);
          if (!in_region(at, terms.normal)) continue;
          const double allowed = task_.tolerance * std::max(terms.at.force.norm(), task_.floor);
          if (!(trust_factor * field_.estimate(at.site, at.x) > allowed)) continue;
          Wanted wanted{.site = at.site, .x = at.x, .candidate = {.at = tip}};
          wanted.candidate.requested = asked_.emplace(key, now).first->second;
          wanted.candidate.order = static_cast<std::uint32_t>(found.size());
          std::vector<StateId> nearest;
          tips_.nearest(tip, 1, nearest);
          wanted.candidate.delta = nearest.empty() ? std::numeric_limits<double>::infinity()
                                                   : (tips_[nearest.front()].at - tip).norm();
          if (parts_.policy->reads_regions()) wanted.candidate.region = tips_.region_label(tip);
          found.emplace(key, wanted);
        }
  }
  std::vector<Wanted> all;
  for (auto& [key, wanted] : found) all.push_back(std::move(wanted));
  return all;
}

PlannerView TouchPlanner::view(double now) const {
  return {.space = tips_,
          .now = now,
          .hip = seen_.tip,
          .predicted = predicted_,
          .solve_seconds = times_.empty() ? parts_.solve_seconds : median(times_),
          .workers = parts_.workers,
          .pending = pending_,
          .surprises = {},
          .estimate = [this](const Vec3& tip) { return estimated_jnds(tip); }};
}

// The model's estimate of its error where the tip is at this place, at the site of the nearest predicted one.
double TouchPlanner::estimated_jnds(const Vec3& tip) const {
  if (pressed_.empty()) return 0;
  const Visit& visit = *std::ranges::min_element(
      pressed_, {}, [&](const Visit& v) { return (v.site.at + v.x - tip).squaredNorm(); });
  const Vec3 x = tip - visit.site.at;
  const double error = std::min(field_.estimate(visit.site, x), 1e3);
  return error / (task_.tolerance * std::max(field_.at(visit.site, x, false).at.force.norm(), task_.floor));
}

TouchJob TouchPlanner::dispatch(const SurfacePlace& site, const Vec3& x, double priority, int worker,
                                double now) {
  const auto id = static_cast<std::uint32_t>(dispatches_.size());
  dispatches_.push_back(
      {.id = id, .site = site.at, .x = x, .priority = priority, .requested = now, .worker = worker});
  places_.push_back(site);
  if (x.isZero(0))
    jets_.push_back(site);
  else
    gone_.emplace(key_of(site, site.at + x), true), pending_.push_back(site.at + x);
  return {.id = id, .site = site, .x = x, .start = starts_.near(site, x)};
}

std::vector<TouchJob> TouchPlanner::plan(const std::vector<int>& idle, double now) {
  std::vector<TouchJob> jobs;
  if (idle.empty()) return jobs;
  predict();
  pressed_ = visits();
  std::size_t next = 0;
  while (next < idle.size()) {
    const std::optional<SurfacePlace> site = missing_jet(pressed_);
    if (!site) break;
    jobs.push_back(dispatch(*site, Vec3::Zero(), std::numeric_limits<double>::infinity(), idle[next++], now));
  }
  if (next == idle.size() || pressed_.empty()) return jobs;
  std::vector<Wanted> open = candidates(pressed_, now);
  if (open.empty()) return jobs;
  parts_.policy->look(view(now));
  while (next < idle.size() && !open.empty() && !parts_.policy->is_content()) {
    std::vector<Candidate> list;
    for (const Wanted& wanted : open) list.push_back(wanted.candidate);
    std::vector<double> priority(list.size());
    parts_.policy->prioritise(list, view(now), priority);
    std::size_t best = 0;
    for (std::size_t i = 1; i < list.size(); ++i)
      if (priority[i] > priority[best]) best = i;
    jobs.push_back(dispatch(open[best].site, open[best].x, priority[best], idle[next++], now));
    open.erase(open.begin() + static_cast<std::ptrdiff_t>(best));
    parts_.policy->pend(view(now));
  }
  return jobs;
}

std::optional<int> TouchPlanner::preempted(double now) {
  constexpr double far_more = 20, least_left = 0.1;
  constexpr int most_often = 2;
  const double solve = times_.empty() ? parts_.solve_seconds : median(times_);
  if (now - preemption_.checked < std::max(0.02, 0.25 * solve)) return {};
  preemption_.checked = now;
  std::vector<const TouchDispatch*> running;
  for (const TouchDispatch& d : dispatches_) {
    if (d.status != DispatchStatus::running || d.x.isZero(0) || preemption_.now.contains(d.id)) continue;
    const auto before = preemption_.counts.find(key_of(places_[d.id], d.site + d.x));
    if (before == preemption_.counts.end() || before->second < most_often) running.push_back(&d);
  }
  if (running.empty()) return {};
  predict();
  pressed_ = visits();
  const bool jet = missing_jet(pressed_).has_value();
  double wanted = std::numeric_limits<double>::infinity();
  if (!jet) {
    const std::vector<Wanted> open = candidates(pressed_, now);
    if (open.empty()) return {};
    parts_.policy->look(view(now));
    wanted = 0;
    for (const Wanted& w : open) wanted = std::max(wanted, parts_.policy->priority(w.candidate, view(now)));
  }
  const TouchDispatch* weakest = nullptr;
  double least = wanted / far_more;
  for (const TouchDispatch* d : running) {
    const double left = std::max(1 - (now - d->requested) / solve, least_left);
    const double worth =
        jet ? 1 / left
            : parts_.policy->priority({.at = d->site + d->x, .delta = task_.tips.spacing}, view(now)) / left;
    if (worth < least) least = worth, weakest = d;
  }
  if (!weakest) return {};
  preemption_.now.insert(weakest->id);
  ++preemption_.counts[key_of(places_[weakest->id], weakest->site + weakest->x)];
  return weakest->worker;
}

bool TouchPlanner::receive(std::uint32_t id, TouchSolved solved, double started, double finished,
                           double now) {
  TouchDispatch& record = dispatches_[id];
  record.started = started, record.finished = finished, record.known = now;
  const SurfacePlace& place = places_[id];
  preemption_.now.erase(id);
  if (const auto at = std::ranges::find(pending_, Vec3(record.site + record.x)); at != pending_.end())
    pending_.erase(at);
  if (solved.state.solve.status == SolveStatus::cancelled) {
    record.status = DispatchStatus::preempted;
    gone_.erase(key_of(place, place.at + record.x));
    return false;
  }
  if (!record.x.isZero(0)) times_.push_back(finished - started);
  if (!solved.state.usable()) {
    record.status = DispatchStatus::failed;
    ++failed_count_;
    return false;
  }
  record.status = DispatchStatus::solved;
  starts_.add(place, solved.equilibrium);
  learn(solved.state);
  return true;
}

const TouchModel* TouchPlanner::model() {
  const TouchModel& last = *models_.back();
  if (!fresh_.empty()) {
    models_.push_back(
        std::make_unique<TouchModel>(TouchModel{.serial = last.serial + 1,
                                                .known = static_cast<std::uint32_t>(known_.size()),
                                                .deep = last.deep->with(fresh_)}));
    fresh_.clear();
  }
  field_.use(models_.back()->deep.get());
  return models_.back().get();
}

std::vector<std::shared_ptr<const DeepStates>> TouchPlanner::models() const {
  std::vector<std::shared_ptr<const DeepStates>> all;
  for (const auto& model : models_) all.push_back(model->deep);
  return all;
}

}  // namespace forefeel
