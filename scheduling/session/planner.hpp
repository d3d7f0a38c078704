#pragma once
// Decides which states are solved and keeps the state space. It is the same under both clocks: the caller
// passes the time.
//   HIP -> predictor -> policy -> job to a worker, or its cancellation
//   state from a worker -> state space; whoever renders makes models of it (render/model_keeper.hpp)
// One thread owns it.

#include <cstdint>
#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

#include "geometry/common/signed_vector.hpp"
#include "scheduling/render/model_keeper.hpp"
#include "scheduling/session/dispatch_log.hpp"
#include "scheduling/session/planner_setup.hpp"
#include "scheduling/session/ranking.hpp"
#include "scheduling/session/solve_starts.hpp"
#include "scheduling/session/surprises.hpp"
#include "scheduling/workers/generator.hpp"

namespace forefeel {

// A state with a site, at the place of the tip; force, stiffness and status alone.
State at_the_tip(const State& state);

class Planner {
 public:
  struct Hooks {
    std::function<void(const State&)> on_state;  // called for each new state, also failed ones; may be empty
    std::function<Vec3(double)> future = {};     // the true motion, for policies that read it
    double expected_solve = 0.01;                // assumed until solves are measured [s]
  };
  Planner(PlannerSetup setup, Generator& generator, Hooks hooks);  // the generator must outlive it
  Planner(const Planner&) = delete;
  Planner& operator=(const Planner&) = delete;

  void receive(JobResult result, double now);  // from the generator
  void arrive(State state, double now);        // adds a state that needs no solve
  void observe(const HipSample& sample);
  void plan(double now);  // dispatches, preempts

  const StateSpace& space() const { return space_; }
  const HipSample& hip() const { return hip_; }  // as observed last
  std::size_t solved() const { return log_.counts.solved; }
  std::size_t failed() const { return log_.counts.failed; }
  std::size_t preempted() const { return log_.counts.preempted; }
  bool idle() const;            // nothing runs
  std::uint32_t known() const;  // number of known states
  // Completes the records. `models` is the keeper of the rendered models. The planner must not be used
  // afterwards.
  void finish(SessionResult& result, ModelMaker& models);

 private:
  enum class Purpose { policy, rest, audit };
  struct Member {
    std::uint32_t dispatch = 0;
    Candidate candidate;
  };
  struct Slot {  // one per worker
    bool cancelling = false, counted = false;
    std::vector<Member> members;  // unfinished states of its job, in solving order
    double since = 0;
    Vec3 hip = Vec3::Zero();  // when it began [m]
    Purpose purpose = Purpose::policy;
    bool busy() const { return !members.empty(); }
  };
  struct Preemption {
    std::unordered_map<std::uint32_t, int> counts;  // by candidate order
    double checked = 0;                             // when it was considered last [s]
  };
  struct Solves {
    SolveStarts starts;  // where they start
    SolveTimes times;    // how long they take
  };
  void remember_known(const State& state);  // at the start
  bool insert(const State& state, std::int64_t dispatch);
  bool insert_at_site(const State& state, std::int64_t dispatch);
  bool is_held(const JobResult& result) const;
  bool is_idle(int worker) const;
  void learn(Slot& slot, const Candidate& candidate, JobResult result, double now);
  void look(double now);
  std::vector<Vec3> pending(const Slot* but = nullptr) const;
  std::vector<Candidate> take_beside(std::vector<Candidate> near);
  Slot& dispatch(int worker, const Candidate& candidate, double priority,
                 const std::vector<Candidate>& beside, double now);
  void dispatch_best(int worker, bool many, double now);
  bool audits(int worker, double now);     // whether this job was an audit, which it then dispatched
  bool rest_comes_first(double now);       // whether nothing else is dispatched yet
  std::size_t dispatch_rests(double now);  // at sites; returns how many
  void consider_preemption(double now);
  Slot* weakest(double now);  // whose job the best candidate is worth far more than; null: none

  const PlannerSetup setup_;
  Generator& generator_;
  std::function<void(const State&)> on_state_;
  StateSpace space_;
  std::optional<Surprises> surprises_;  // none unless requested
  std::optional<JetEstimates> jets_;    // none unless requested, or without jets
  Ranking ranking_;
  HipSample hip_;
  SignedVector<Slot> slots_;
  Preemption preemption_;
  Solves solves_;
  DispatchLog log_;
  std::uint64_t audit_draws_ = 0;
};

}  // namespace forefeel
