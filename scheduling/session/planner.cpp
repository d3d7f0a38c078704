#include "scheduling/session/planner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/common/quantiles.hpp"
#include "scheduling/session/plausible.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {
namespace {

std::vector<State> failed_of(std::span<const State> states) {
  std::vector<State> failed;
  for (const State& state : states)
    if (!state.usable()) failed.push_back(state);
  return failed;
}

// A state that its neighbours contradict counts as a failed solve, in the states' file too.
bool set_aside(State& state, const StateSpace& space, const Mat3& stiffest) {
  if (!state.usable() || !is_far_too_strong(state, space, stiffest)) return false;
  state.solve.status = SolveStatus::diverged;
  return true;
}

std::string failure_of(const State& state, bool was_set_aside) {
  return fmt::format("solve at {:.4g}, {:.4g}, {:.4g} m failed: {}", state.at.x(), state.at.y(), state.at.z(),
                     was_set_aside ? fmt::format("set aside, over {:g} times as strong as known states "
                                                 "beside it or as this body can be, or not a number",
                                                 implausible_factor)
                                   : std::string(name(state.solve.status)));
}

}  // namespace

Planner::Planner(PlannerSetup setup, Generator& generator, Hooks hooks)
    : setup_(std::move(setup)),
      generator_(generator),
      hooks_(std::move(hooks)),
      space_(setup_.space),
      solve_seconds_(std::max(hooks_.expected_solve, 1e-6)) {
  for (const State& state : setup_.known) {
    if (!state.usable() || !space_.insert(state).is_new) continue;
    dispatch_of_.push_back(-1);
    if (state.displacements) {
      auto known = std::make_shared<Equilibrium>();
      known->at = state.at;
      known->displacements = *state.displacements;
      remember_start(state.at, -1, std::move(known));
    }
  }
  counts_.start = space_.size();
  candidates_ = std::make_unique<Candidates>(space_, failed_of(setup_.known), setup_.placement);
  if (setup_.policy->reads_surprises()) judge_ = std::make_unique<SessionModel>(space_, setup_.model);
  // As many starts as fit half a gigabyte with their tangents (4 times the displacements).
  start_limit_ = std::clamp<std::size_t>((std::size_t{1} << 29) / (setup_.nodes * 96 + 1), 16, 65536);
}

// Measures all of the first states. Later the estimate changes little, and one state in eight is measured.
void Planner::note_surprise(const State& state) {
  constexpr std::size_t all = 64, every = 8;
  if (!judge_ || space_.empty() || space_.find(state.at).valid()) return;
  if (space_.size() > all && space_.size() % every != 0) return;
  judge_->forget();
  const Vec3 error = judge_->model_at(state.at).force(state.at) - state.force;
  const SwitchOptions& jnd = setup_.jnd;
  surprises_.resize(space_.size(), std::numeric_limits<float>::quiet_NaN());
  surprises_.push_back(
      static_cast<float>(error.norm() / std::max(jnd.jnd_share * state.force.norm(), jnd.jnd_floor)));
}

bool Planner::insert(const State& state, std::int64_t dispatch) {
  note_surprise(state);
  if (!space_.insert(state).is_new) return false;
  dispatch_of_.push_back(dispatch);
  candidates_->learn(state.at);
  return true;
}

// Whether the worker has this dispatch and has not returned it yet.
bool Planner::is_held(const JobResult& result) const {
  const auto worker = static_cast<std::size_t>(result.worker);
  if (result.worker < 0 || worker >= slots_.size()) return false;
  const auto& members = slots_[worker].members;
  return std::ranges::find(members, result.dispatch, &Member::dispatch) != members.end();
}

// Custom workers may misbehave: a result of an unknown job is ignored; one at the wrong position counts as failed.
void Planner::receive(JobResult result, double now) {
  if (!is_held(result)) {
    ++strays_;
    return;
  }
  const Vec3& asked = dispatches_[result.dispatch].at;
  if (result.state.solve.status != SolveStatus::cancelled && !((result.state.at - asked).norm() <= 1e-9)) {
    ++elsewhere_;
    result.state.at = asked;
    result.state.solve.status = SolveStatus::diverged;
  }
  DispatchRecord& record = dispatches_[result.dispatch];
  Slot& slot = slots_[static_cast<std::size_t>(result.worker)];
  const auto member = std::ranges::find(slot.members, result.dispatch, &Member::dispatch);
  const Candidate candidate = member->candidate;
  slot.members.erase(member);
  slot.cancelling = slot.cancelling && slot.busy();
  const bool began = result.state.solve.status != SolveStatus::cancelled || result.finished > result.started;
  record.started = began ? result.started : unknown;
  record.finished = result.finished;
  if (result.state.solve.status == SolveStatus::cancelled) {
    record.status = began ? DispatchStatus::preempted : DispatchStatus::withdrawn;
    counts_.preempted += began ? 1 : 0;
    ++preemptions_[candidate.order];
    if (result.partial) partial_[candidate.order] = std::move(result.partial);
    if (!record.audit) candidates_->put_back(candidate);
    return;
  }
  record.known = now;
  if (slot.busy()) {  // a job's states are solved in their order
    DispatchRecord& next = dispatches_[slot.members.front().dispatch];
    if (std::isnan(next.started)) next.started = result.finished;
  }
  jobs_ += slot.counted || slot.rest ? 0 : 1;
  slot.counted = true;
  note_cost(result.finished - result.started, setup_.rest_first && result.state.at.isZero(0));
  if (record.parent >= 0) result.state.solve.parent = dispatches_[static_cast<std::size_t>(record.parent)].at;
  const bool aside = set_aside(result.state, space_, setup_.stiffest);
  if (hooks_.on_state) hooks_.on_state(result.state);
  if (!result.state.usable()) {
    record.status = DispatchStatus::failed;
    ++counts_.failed;
    counts_.set_aside += aside ? 1 : 0;
    if (!record.audit) candidates_->fail(candidate.at);
    notes_.push_back(failure_of(result.state, aside));
    return;
  }
  record.status = DispatchStatus::solved;
  ++counts_.solved;
  insert(result.state, result.dispatch);
  remember_start(result.state.at, result.dispatch, std::move(result.equilibrium));
}

void Planner::arrive(State state, double now) {
  DispatchRecord record{
      .id = static_cast<std::uint32_t>(dispatches_.size()), .at = state.at, .label = space_.label(state.at)};
  record.requested = record.finished = record.known = now;
  const bool aside = set_aside(state, space_, setup_.stiffest);
  if (aside) notes_.push_back(failure_of(state, aside));
  counts_.set_aside += aside ? 1 : 0;
  record.status = state.usable() ? DispatchStatus::arrived : DispatchStatus::failed;
  const std::int64_t row = record.id;
  dispatches_.push_back(record);
  if (hooks_.on_state) hooks_.on_state(state);
  if (!state.usable())
    ++counts_.failed;
  else if (insert(state, row))
    ++counts_.solved;
}

void Planner::observe(const HipSample& sample) {
  hip_ = sample;
  setup_.predictor->observe(sample);
}

// The time of the state at rest is not typical of other states, so it is left out.
void Planner::note_cost(double seconds, bool at_rest) {
  if (at_rest) return;
  costs_.push_back(seconds);
  if (recent_costs_.size() == 31) recent_costs_.erase(recent_costs_.begin());
  recent_costs_.push_back(seconds);
  solve_seconds_ = std::max(median(recent_costs_), 1e-6);
}

void Planner::remember_start(const Vec3& at, std::int64_t dispatch,
                             std::shared_ptr<const Equilibrium> equilibrium) {
  if (starts_.size() >= start_limit_) {  // forget the one farthest from the HIP
    const auto far = std::max_element(starts_.begin(), starts_.end(), [&](const Start& a, const Start& b) {
      return (a.at - hip_.at).squaredNorm() < (b.at - hip_.at).squaredNorm();
    });
    *far = {at, dispatch, std::move(equilibrium)};
  } else {
    starts_.push_back({at, dispatch, std::move(equilibrium)});
  }
}

const Planner::Start* Planner::nearest_start(const Vec3& x) const {
  const Start* best = nullptr;
  double distance = x.squaredNorm();  // rest is always known
  for (const Start& start : starts_) {
    const double d = (start.at - x).squaredNorm();
    if (d < distance) {
      distance = d;
      best = &start;
    }
  }
  return best;
}

// One job after the other: priorities depend on the jobs just dispatched.
void Planner::plan(double now) {
  slots_.resize(std::max(slots_.size(), static_cast<std::size_t>(generator_.workers())));
  if (slots_.empty() || (candidates_->empty() && !candidates_->may_grow())) return;
  std::size_t idle_workers = 0;
  for (std::size_t worker = 0; worker < slots_.size(); ++worker) idle_workers += is_idle(worker) ? 1 : 0;
  if (idle_workers == 0) return consider_preemption(now);
  if (rest_comes_first(now)) return;
  look(now);
  const bool many = idle_workers > 1 && setup_.batch == 1 && std::isfinite(setup_.policy->at_most(1));
  if (many) rank_for_many(now);
  for (std::size_t worker = 0; worker < slots_.size() && idle_workers > 0 && !candidates_->empty();
       ++worker) {
    if (!is_idle(worker)) continue;
    if (audits(static_cast<int>(worker), now)) {
      if (--idle_workers > 0) setup_.policy->pend(view(now));
      continue;
    }
    if (!many) rank(now);
    double priority = 0;
    const std::size_t chosen = many ? best_of_many(now, priority) : best();
    if (!many) priority = priorities_[chosen];
    std::vector<std::pair<double, Candidate>> near = neighbours_of(chosen);
    const Candidate candidate = candidates_->refreshed(candidates_->take(chosen));
    const std::vector<Candidate> beside = take_neighbours(std::move(near));
    dispatch(static_cast<int>(worker), candidate, priority, beside, now);
    pending_.push_back(candidate.at);
    for (const Candidate& c : beside) pending_.push_back(c.at);
    if (--idle_workers > 0) setup_.policy->pend(view(now));
  }
}

bool Planner::is_idle(std::size_t worker) const {
  return !slots_[worker].busy() && generator_.takes_jobs(static_cast<int>(worker));
}

// While no state is known, one worker solves rest. The others wait until rest is known or the hand has moved
// a third of a spacing. Their jobs take about ten times as long, and the choice is better once the direction
// of motion is known.
bool Planner::rest_comes_first(double now) {
  if (!setup_.rest_first || !space_.empty()) return false;
  if (dispatches_.empty()) {
    const std::optional<Candidate> rest = candidates_->take_rest();
    if (!rest) return false;
    dispatch(0, *rest, 1.0, {}, now);
    slots_[0].rest = true;
    began_at_ = hip_.at;
  }
  return slots_[0].rest && slots_[0].busy() && (hip_.at - began_at_).norm() < space_.options().spacing / 3;
}

// The open candidates next to one, with their priorities.
std::vector<std::pair<double, Candidate>> Planner::neighbours_of(std::size_t chosen) const {
  std::vector<std::pair<double, Candidate>> near;
  if (setup_.batch < 2) return near;
  const auto open = candidates_->open();
  for (std::size_t i = 0; i < open.size(); ++i)
    if (i != chosen && !open[i].passing &&
        (open[i].at - open[chosen].at).norm() <= 1.1 * space_.options().spacing)
      near.emplace_back(priorities_[i], open[i]);
  return near;
}

// The best of them; they reuse the factorisation of the chosen state.
std::vector<Candidate> Planner::take_neighbours(std::vector<std::pair<double, Candidate>> near) {
  std::vector<Candidate> taken;
  std::ranges::sort(near, [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second.order < b.second.order;
  });
  for (const auto& [priority, candidate] : near) {
    if (static_cast<int>(taken.size()) + 1 >= setup_.batch) break;
    if (const auto place = candidates_->index_of(candidate))
      taken.push_back(candidates_->refreshed(candidates_->take(*place)));
  }
  return taken;
}

std::uint32_t Planner::record_dispatch(int worker, const Candidate& candidate, double priority,
                                       std::int64_t parent, double now) {
  DispatchRecord record{.id = static_cast<std::uint32_t>(dispatches_.size()),
                        .at = candidate.at,
                        .label = candidate.region,
                        .priority = priority};
  record.requested = std::isfinite(candidate.requested) ? candidate.requested : now;
  record.started = now + setup_.latency;  // until the worker tells
  record.status = DispatchStatus::running;
  record.worker = worker;
  record.parent = parent;
  dispatches_.push_back(record);
  return record.id;
}

void Planner::dispatch(int worker, const Candidate& candidate, double priority,
                       const std::vector<Candidate>& beside, double now) {
  const Start* start = nearest_start(candidate.at);
  Slot& slot = slots_[static_cast<std::size_t>(worker)];
  slot = {.cancelling = false, .counted = false, .members = {}, .since = now, .rest = false, .audit = false};
  Job job{.dispatch = record_dispatch(worker, candidate, priority, start ? start->dispatch : -1, now),
          .at = candidate.at,
          .start = start ? start->equilibrium : nullptr,
          .beside = {}};
  if (const auto partial = partial_.find(candidate.order); partial != partial_.end()) {
    job.start = std::move(partial->second);
    partial_.erase(partial);
  }
  slot.members.push_back({job.dispatch, candidate});
  for (const Candidate& c : beside) {
    job.beside.push_back({.dispatch = record_dispatch(worker, c, priority, job.dispatch, now), .at = c.at});
    dispatches_[job.beside.back().dispatch].started = unknown;  // not before the one before it is done
    slot.members.push_back({job.beside.back().dispatch, c});
  }
  generator_.dispatch(worker, std::move(job));
}

// A running job is cancelled if a waiting candidate is worth twenty times as much. The job's worth is its
// priority divided by the remaining share of its solve; both priorities are computed as if neither were being
// solved. A lower threshold cancels job after job in fast motions, because predictions change faster than
// states are solved. No candidate is cancelled more than twice, so each is solved in the end.
void Planner::consider_preemption(double now) {
  if (!setup_.preempt || candidates_->empty() ||
      now - preemption_checked_ < std::max(0.02, 0.25 * solve_seconds_))
    return;
  preemption_checked_ = now;
  look(now);
  if (candidates_->empty()) return;
  rank(now);
  const Candidate waiting = candidates_->open()[best()];
  Slot* weakest = nullptr;
  double least = 0.05;
  for (Slot& slot : slots_) {
    const bool enough = std::ranges::any_of(slot.members, [&](const Member& member) {
      const auto before = preemptions_.find(member.candidate.order);
      return before != preemptions_.end() && before->second >= 2;
    });
    if (slot.cancelling || slot.rest || slot.audit || enough) continue;
    gather_pending(&slot);
    const PlannerView seen = view(now);
    setup_.policy->pend(seen);
    const double gain = ranked_by(setup_.policy->priority(waiting, seen));
    const double left = std::max(1 - (now - slot.since) / solve_seconds_, 0.1);
    double worth = 0;
    for (const Member& member : slot.members)
      worth = std::max(
          worth, ranked_by(setup_.policy->priority(candidates_->refreshed(member.candidate), seen)) / left);
    if (gain > 0 && worth < least * gain) {
      least = worth / gain;
      weakest = &slot;
    }
  }
  if (!weakest) return;
  weakest->cancelling = true;
  generator_.cancel(static_cast<int>(weakest - slots_.data()));
}

bool Planner::idle() const {
  return std::none_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.busy(); });
}

void Planner::finish(SessionResult& result, ModelKeeper& models) {
  for (std::size_t id = 0; id < models.first_used().size(); ++id)
    if (dispatch_of_[id] >= 0)
      dispatches_[static_cast<std::size_t>(dispatch_of_[id])].first_used = models.first_used()[id];
  for (std::size_t i = 0; i < space_.size(); ++i)
    result.states.push_back(space_[StateId{static_cast<std::uint32_t>(i)}]);
  for (DispatchRecord& record : dispatches_)
    if (record.status == DispatchStatus::running && std::isnan(record.started))
      record.status = DispatchStatus::waiting;
  result.dispatch = std::move(dispatches_);
  result.switches = models.take_switches();
  result.counts = counts_;
  result.solver.seconds = std::move(costs_);
  result.solver.jobs = jobs_;
  result.notes.insert(result.notes.end(), notes_.begin(), notes_.end());
  if (const auto& wrong = priorities_refused_; wrong.not_numbers + wrong.infinite + wrong.negative > 0)
    result.notes.push_back(
        fmt::format("policy {} gave priorities that are not finite numbers of at least 0: {} not numbers, {} "
                    "infinite, {} negative; they were sorted by <, NaN last",
                    setup_.policy->name(), wrong.not_numbers, wrong.infinite, wrong.negative));
  if (strays_ > 0)
    result.notes.push_back(
        fmt::format("the workers gave {} results that belong to no running job: they were ignored", strays_));
  if (elsewhere_ > 0)
    result.notes.push_back(fmt::format(
        "the workers gave {} states at other positions than asked for: they counted as failed", elsewhere_));
  if (predictions_refused_ > 0)
    result.notes.push_back(fmt::format(
        "the predictor gave {} positions that are not finite or deviations that are not at least 0: the hand "
        "counted as staying where it was, the deviation as 0",
        predictions_refused_));
}

}  // namespace forefeel
