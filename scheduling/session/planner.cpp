#include "scheduling/session/planner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scheduling/session/plausible.hpp"
#include "scheduling/touch/surface_models.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {
namespace {

// Of a body that may be touched anywhere, first the sites of its field: jets at rest are states at x = 0.
StateSpace known_space(const PlannerSetup& setup) {
  StateSpace space(setup.space);
  if (setup.surface) {
    const SiteField& field = *setup.surface->task().field;
    for (std::size_t i = 0; i < field.size(); ++i) {
      State rest;
      rest.at = field.place(i).at;
      space.insert(std::move(rest));
    }
    return space;
  }
  for (const State& state : setup.known)
    if (state.usable()) space.insert(state);
  return space;
}

// A state that its neighbours contradict counts as a failed solve, in the states' file too.
bool set_aside(State& state, const StateSpace& space, const Mat3& stiffest) {
  const bool at_site = state.has_site();
  if (!state.usable() ||
      !is_far_too_strong(at_site ? at_the_tip(state) : state, space, at_site ? Mat3::Zero() : stiffest))
    return false;
  state.solve.status = SolveStatus::diverged;
  return true;
}

// Whether a worker solved what it was asked for.
bool is_at(const State& state, const Candidate& asked) {
  if (asked.site.exists() && !((state.site - asked.site.at).norm() <= 1e-9)) return false;
  return (state.at - asked.displacement()).norm() <= 1e-9;
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
      on_state_(std::move(hooks.on_state)),
      space_(known_space(setup_)),
      ranking_(setup_, space_, std::move(hooks.future)),
      solves_{SolveStarts(setup_.body.nodes), SolveTimes(hooks.expected_solve)} {
  if (setup_.surface) {
    for (const State& state : setup_.known)
      if (state.usable() && state.has_site()) insert_at_site(state, -1);
  } else {
    for (std::uint32_t id = 0; id < space_.size(); ++id) remember_known(space_[StateId{id}]);
  }
  log_.counts.start = known();
  if (!setup_.policy->reads_surprises()) return;
  surprises_.emplace(space_, setup_);
  if (setup_.model.fit.data == Data::jet && !setup_.surface)
    jets_.emplace(space_, setup_.model.fit, setup_.jnd);
}

void Planner::remember_known(const State& state) {
  log_.know(-1);
  if (!state.displacements) return;
  auto known = std::make_shared<Equilibrium>();
  known->at = state.at;
  known->displacements = *state.displacements;
  solves_.starts.remember(
      {.at = state.at, .site = Vec3::Zero(), .dispatch = -1, .equilibrium = std::move(known)}, hip_.at);
}

bool Planner::insert(const State& state, std::int64_t dispatch) {
  if (setup_.surface) return insert_at_site(state, dispatch);
  if (surprises_) surprises_->note(state, state.at);
  if (!space_.insert(state).is_new) return false;
  log_.know(dispatch);
  ranking_.candidates().learn({.at = state.at});
  return true;
}

std::uint32_t Planner::known() const {
  return static_cast<std::uint32_t>(setup_.surface ? setup_.surface->known().size() : space_.size());
}

// Whether the worker has this dispatch and has not returned it yet.
bool Planner::is_held(const JobResult& result) const {
  if (result.worker < 0 || result.worker >= slots_.count()) return false;
  const auto& members = slots_[result.worker].members;
  return std::ranges::find(members, result.dispatch, &Member::dispatch) != members.end();
}

// Custom workers may misbehave: a result of an unknown job is ignored; one at the wrong position counts as failed.
void Planner::receive(JobResult result, double now) {
  if (!is_held(result)) {
    ++log_.strays;
    return;
  }
  DispatchRecord& record = log_[result.dispatch];
  const bool cancelled = result.state.solve.status == SolveStatus::cancelled;
  Slot& slot = slots_[result.worker];
  const auto member = std::ranges::find(slot.members, result.dispatch, &Member::dispatch);
  const Candidate candidate = member->candidate;
  if (!cancelled && !is_at(result.state, candidate)) {
    ++log_.elsewhere;
    result.state.at = candidate.displacement();
    if (candidate.site.exists()) result.state.site = candidate.site.at;
    result.state.solve.status = SolveStatus::diverged;
  }
  slot.members.erase(member);
  slot.cancelling = slot.cancelling && slot.busy();
  const bool began = !cancelled || result.finished > result.started;
  record.started = began ? result.started : unknown;
  record.finished = result.finished;
  if (!cancelled) return learn(slot, candidate, std::move(result), now);
  record.status = began ? DispatchStatus::preempted : DispatchStatus::withdrawn;
  log_.counts.preempted += began ? 1 : 0;
  ++preemption_.counts[candidate.order];
  solves_.starts.keep_partial(candidate, std::move(result.partial));
  if (!record.choice.audit) ranking_.candidates().put_back(candidate);
}

// A state that was solved or has failed.
void Planner::learn(Slot& slot, const Candidate& candidate, JobResult result, double now) {
  DispatchRecord& record = log_[result.dispatch];
  record.known = now;
  if (slot.busy()) {  // a job's states are solved in their order
    DispatchRecord& next = log_[slot.members.front().dispatch];
    if (std::isnan(next.started)) next.started = result.finished;
  }
  log_.jobs += slot.counted || slot.purpose == Purpose::rest ? 0 : 1;
  slot.counted = true;
  // The time of the state at rest is not typical of other states, so it is left out.
  if (!setup_.options.rest_first || !result.state.at.isZero(0))
    solves_.times.note(result.finished - result.started);
  if (record.parent >= 0 && !setup_.surface)
    result.state.solve.parent = log_[static_cast<std::uint32_t>(record.parent)].at;
  const bool aside = set_aside(result.state, space_, setup_.body.stiffest);
  if (on_state_) on_state_(result.state);
  if (!result.state.usable()) {
    record.status = DispatchStatus::failed;
    ++log_.counts.failed;
    log_.counts.set_aside += aside ? 1 : 0;
    if (!record.choice.audit) ranking_.candidates().fail(candidate);
    log_.notes.push_back(failure_of(result.state, aside));
    return;
  }
  record.status = DispatchStatus::solved;
  ++log_.counts.solved;
  insert(result.state, result.dispatch);
  if (result.equilibrium || !setup_.surface)
    solves_.starts.remember(
        {result.state.at, candidate.site.at, result.dispatch, std::move(result.equilibrium)}, hip_.at);
}

void Planner::arrive(State state, double now) {
  const Label label = space_.label(state.tip());
  const bool aside = set_aside(state, space_, setup_.body.stiffest);
  if (aside) log_.notes.push_back(failure_of(state, aside));
  log_.counts.set_aside += aside ? 1 : 0;
  const std::uint32_t row = log_.arrive(state, label, now);
  if (on_state_) on_state_(state);
  if (!state.usable())
    ++log_.counts.failed;
  else if (insert(state, row))
    ++log_.counts.solved;
}

void Planner::observe(const HipSample& sample) {
  hip_ = sample;
  setup_.predictor->observe(sample);
}

// One job after the other: priorities depend on the jobs just dispatched.
void Planner::plan(double now) {
  slots_.resize(std::max(slots_.size(), static_cast<std::size_t>(generator_.workers())));
  Candidates& candidates = ranking_.candidates();
  if (slots_.empty() || (candidates.empty() && !candidates.may_grow())) return;
  std::size_t idle_workers = 0;
  for (int worker = 0; worker < slots_.count(); ++worker) idle_workers += is_idle(worker) ? 1 : 0;
  if (idle_workers == 0) return consider_preemption(now);
  if (rest_comes_first(now)) return;
  look(now);
  if (setup_.surface) idle_workers -= dispatch_rests(now);
  if (idle_workers == 0) return;
  ++log_.plans.all;
  if (setup_.policy->is_content()) {
    ++log_.plans.content;
    return;
  }
  const bool many = idle_workers > 1 && setup_.options.batch == 1 && ranking_.ranks_many();
  if (many) ranking_.begin_many();
  for (int worker = 0; worker < slots_.count() && idle_workers > 0 && !candidates.empty(); ++worker) {
    if (!is_idle(worker)) continue;
    if (!audits(worker, now)) dispatch_best(worker, many, now);
    if (--idle_workers > 0) ranking_.tell();
  }
}

void Planner::dispatch_best(int worker, bool many, double now) {
  Candidates& candidates = ranking_.candidates();
  const Ranking::Chosen chosen = many ? ranking_.best_of_many() : ranking_.best();
  std::vector<Candidate> near;
  if (setup_.options.batch > 1) near = ranking_.beside(chosen.place);
  const Candidate candidate = candidates.refreshed(candidates.take(chosen.place));
  const std::vector<Candidate> beside = take_beside(std::move(near));
  dispatch(worker, candidate, chosen.priority, beside, now);
  ranking_.pend(candidate.at);
  for (const Candidate& c : beside) ranking_.pend(c.at);
}

bool Planner::is_idle(int worker) const {
  return !slots_[worker].busy() && generator_.takes_jobs(worker);
}

void Planner::look(double now) {
  ranking_.look({.now = now,
                 .hip = hip_,
                 .solve_seconds = solves_.times.expected(),
                 .workers = generator_.workers(),
                 .surprises = surprises_ ? surprises_->by_id() : std::span<const float>(),
                 .estimate = jets_ ? std::ref(*jets_) : std::function<double(const Vec3&)>()},
                pending());
}

std::vector<Vec3> Planner::pending(const Slot* but) const {
  std::vector<Vec3> at;
  for (const Slot& slot : slots_)
    if (!slot.cancelling && &slot != but)
      for (const Member& member : slot.members) at.push_back(member.candidate.at);
  return at;
}

// While no state is known, one worker solves rest. The others wait until rest is known or the hand has moved
// a third of a spacing. Their jobs take about ten times as long, and the choice is better once the direction
// of motion is known.
bool Planner::rest_comes_first(double now) {
  if (!setup_.options.rest_first || !space_.empty() || setup_.surface) return false;
  if (log_.rows().empty()) {
    const std::optional<Candidate> rest = ranking_.candidates().take_rest();
    if (!rest) return false;
    dispatch(0, *rest, 1.0, {}, now).purpose = Purpose::rest;
  }
  const Slot& first = slots_[0];
  return first.purpose == Purpose::rest && first.busy() &&
         (hip_.at - first.hip).norm() < space_.options().spacing / 3;
}

// The best candidates beside a chosen one; they reuse the factorisation of its state.
std::vector<Candidate> Planner::take_beside(std::vector<Candidate> near) {
  Candidates& candidates = ranking_.candidates();
  std::vector<Candidate> taken;
  for (const Candidate& candidate : near) {
    if (static_cast<int>(taken.size()) + 1 >= setup_.options.batch) break;
    if (const auto place = candidates.index_of(candidate))
      taken.push_back(candidates.refreshed(candidates.take(*place)));
  }
  return taken;
}

Planner::Slot& Planner::dispatch(int worker, const Candidate& candidate, double priority,
                                 const std::vector<Candidate>& beside, double now) {
  const SolveStarts::Start* start = solves_.starts.nearest(candidate);
  Slot& slot = slots_[worker];
  slot = {.members = {}, .since = now, .hip = hip_.at};
  Job job{.dispatch = log_.begin(worker, candidate, priority, start ? start->dispatch : -1, now,
                                 now + setup_.latency),
          .at = candidate.displacement(),
          .site = candidate.site,
          .start = start ? start->equilibrium : nullptr,
          .beside = {}};
  if (auto partial = solves_.starts.take_partial(candidate)) job.start = std::move(partial);
  slot.members.push_back({job.dispatch, candidate});
  for (const Candidate& c : beside) {  // none begins before the one before it is done
    job.beside.push_back(
        {.dispatch = log_.begin(worker, c, priority, job.dispatch, now, unknown), .at = c.at});
    slot.members.push_back({job.beside.back().dispatch, c});
  }
  generator_.dispatch(worker, std::move(job));
  return slot;
}

// A running job is cancelled if a waiting candidate is worth twenty times as much. The job's worth is its
// priority divided by the remaining share of its solve; both priorities are computed as if neither were being
// solved. A lower threshold cancels job after job in fast motions, because predictions change faster than
// states are solved. No candidate is cancelled more than twice, so each is solved in the end.
void Planner::consider_preemption(double now) {
  const Candidates& candidates = ranking_.candidates();
  if (!setup_.options.preempt || (candidates.empty() && !setup_.surface) ||
      now - preemption_.checked < std::max(0.02, 0.25 * solves_.times.expected()))
    return;
  preemption_.checked = now;
  look(now);
  if (candidates.empty() && !candidates.wants_rest()) return;
  Slot* slot = weakest(now);
  if (!slot) return;
  slot->cancelling = true;
  generator_.cancel(static_cast<int>(slot - slots_.data()));
}

Planner::Slot* Planner::weakest(double now) {
  const bool rest = ranking_.candidates().wants_rest();  // worth more than all others
  const Candidate waiting = rest ? Candidate() : ranking_.candidates().open()[ranking_.best().place];
  Slot* weakest = nullptr;
  double least = rest ? std::numeric_limits<double>::infinity() : 0.05;
  for (Slot& slot : slots_) {
    const bool enough = std::ranges::any_of(slot.members, [&](const Member& member) {
      const auto before = preemption_.counts.find(member.candidate.order);
      return before != preemption_.counts.end() && before->second >= 2;
    });
    if (slot.cancelling || slot.purpose != Purpose::policy || enough) continue;
    ranking_.pend(pending(&slot));
    const double gain = rest ? 1 : ranking_.worth(waiting);
    const double left = std::max(1 - (now - slot.since) / solves_.times.expected(), 0.1);
    double worth = 0;
    for (const Member& member : slot.members)
      worth = std::max(worth, ranking_.worth(ranking_.candidates().refreshed(member.candidate)) / left);
    if (gain > 0 && worth < least * gain) {
      least = worth / gain;
      weakest = &slot;
    }
  }
  return weakest;
}

bool Planner::idle() const {
  return std::none_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.busy(); });
}

void Planner::finish(SessionResult& result, ModelMaker& models) {
  if (setup_.surface) result.states = setup_.surface->known();
  for (std::size_t i = 0; i < space_.size() && !setup_.surface; ++i)
    result.states.push_back(space_[StateId{static_cast<std::uint32_t>(i)}]);
  log_.finish(result, models);
  result.solver.seconds = solves_.times.take();
  for (std::string& line : ranking_.complaints()) result.notes.push_back(std::move(line));
  if (log_.plans.content > 0)
    result.notes.push_back(fmt::format(
        "workers stayed idle in {:.0f} % of the planning steps: the model estimated no error above the JND",
        100.0 * static_cast<double>(log_.plans.content) / static_cast<double>(log_.plans.all)));
  if (log_.strays > 0)
    result.notes.push_back(fmt::format(
        "the workers gave {} results that belong to no running job: they were ignored", log_.strays));
  if (log_.elsewhere > 0)
    result.notes.push_back(
        fmt::format("the workers gave {} states at other positions than asked for: they counted as failed",
                    log_.elsewhere));
}

}  // namespace forefeel
