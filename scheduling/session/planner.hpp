#pragma once
// Decides which states are solved and keeps the state space. It is the same under both clocks: the caller
// passes the time.
//   HIP -> predictor -> policy -> job to a worker, or its cancellation
//   state from a worker -> state space; whoever renders makes models of it (render/model_keeper.hpp)
// One thread owns it.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "scheduling/common/session_result.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/policy/candidates.hpp"
#include "scheduling/render/model_keeper.hpp"
#include "scheduling/render/session_model.hpp"
#include "scheduling/workers/generator.hpp"

namespace forefeel {

// Audits: solves at places where the HIP has just been, instead of those that the policy chooses. They calibrate the
// error bars.
struct AuditPlan {
  double share = 0;  // of the solves
  std::uint64_t seed = 0;
};

// Settings and parts of a planner. Only the constructor reads `known`.
struct PlannerSetup {
  StateSpaceOptions space = {};
  std::span<const State> known = {};  // at the start; failed states are not tried again
  std::size_t nodes = 0;              // of the body's mesh; limits how many solutions are kept as starts
  std::shared_ptr<Policy> policy = {};
  std::shared_ptr<Predictor> predictor = {};
  Placement placement = Placement::lattice;
  int batch = 1;  // states of one job
  bool preempt = true, rest_first = true;
  double latency = 0;  // of a message to or from a worker [s]
  ModelRecipe model = {};
  SwitchOptions jnd = {};  // unit of PlannerView::surprises
  AuditPlan audits = {};
  Mat3 stiffest =
      Mat3::Zero();  // K_b, bound of the body's stiffness at rest [N/m] (plausible.hpp); zero: unknown
};

class Planner {
 public:
  struct Hooks {
    std::function<void(const State&)> on_state;  // called for each new state, also failed ones; may be empty
    std::function<Vec3(double)> future = {};     // the true motion, for policies that read it
    double expected_solve = 0.01;                // assumed until solves are measured [s]
  };
  Planner(PlannerSetup setup, Generator& generator, Hooks hooks);  // the generator must outlive it

  void receive(JobResult result, double now);  // from the generator
  void arrive(State state, double now);        // adds a state that needs no solve
  void observe(const HipSample& sample);
  void plan(double now);  // dispatches, preempts

  const StateSpace& space() const { return space_; }
  const HipSample& hip() const { return hip_; }  // as observed last
  std::size_t solved() const { return counts_.solved; }
  std::size_t failed() const { return counts_.failed; }
  std::size_t preempted() const { return counts_.preempted; }
  bool idle() const;  // nothing runs
  // Completes the records. `models` is the keeper of the rendered models. The planner must not be used
  // afterwards.
  void finish(SessionResult& result, ModelKeeper& models);

 private:
  struct Member {
    std::uint32_t dispatch = 0;
    Candidate candidate;
  };
  struct Slot {  // one per worker
    bool cancelling = false, counted = false;
    std::vector<Member> members;  // unfinished states of its job, in solving order
    double since = 0;
    bool rest = false;   // its job is the state at rest
    bool audit = false;  // its job is an audit
    bool busy() const { return !members.empty(); }
  };
  struct Ranked {  // in a heap, the best is on top
    double priority = 0;
    Candidate candidate;
    std::size_t pending = 0;  // number of pending positions when it was ranked
    friend bool operator<(const Ranked& a, const Ranked& b) {
      return a.priority != b.priority ? a.priority < b.priority : a.candidate.order > b.candidate.order;
    }
  };
  struct Start {  // a solution to start from
    Vec3 at;
    std::int64_t dispatch;
    std::shared_ptr<const Equilibrium> equilibrium;
  };
  bool insert(const State& state, std::int64_t dispatch);
  bool is_held(const JobResult& result) const;
  bool is_idle(std::size_t worker) const;
  void predict(double now);
  Prediction checked(Prediction p);
  PlannerView view(double now) const;
  void rank(double now);              // priorities of the open candidates
  double ranked_by(double priority);  // counts those that break the contract of policies
  void look(double now);              // before anything is ranked at this time
  std::size_t best() const;           // index of the open candidate to solve next
  void rank_for_many(double now);     // into the heap
  std::size_t best_of_many(double now, double& priority);
  std::vector<std::pair<double, Candidate>> neighbours_of(std::size_t chosen) const;
  std::vector<Candidate> take_neighbours(std::vector<std::pair<double, Candidate>> near);
  void gather_pending(const Slot* but);
  std::uint32_t record_dispatch(int worker, const Candidate& candidate, double priority, std::int64_t parent,
                                double now);
  void dispatch(int worker, const Candidate& candidate, double priority, const std::vector<Candidate>& beside,
                double now);
  bool audits(int worker, double now);  // whether this job was an audit, which it then dispatched
  bool rest_comes_first(double now);    // whether nothing else is dispatched yet
  void consider_preemption(double now);
  const Start* nearest_start(const Vec3& x) const;
  void remember_start(const Vec3& at, std::int64_t dispatch, std::shared_ptr<const Equilibrium> equilibrium);
  void note_cost(double seconds, bool at_rest);
  void note_surprise(const State& state);  // before it is inserted

  const PlannerSetup setup_;
  Generator& generator_;
  Hooks hooks_;
  StateSpace space_;
  std::vector<std::int64_t> dispatch_of_;  // by state id: row of dispatch; -1: known at the start
  std::unique_ptr<Candidates> candidates_;
  std::unique_ptr<SessionModel> judge_;  // predicts states as they come; null unless requested
  std::vector<float> surprises_;         // by state id

  HipSample hip_;
  Vec3 began_at_ = Vec3::Zero();

  std::vector<Slot> slots_;
  std::vector<Start> starts_;
  std::size_t start_limit_ = 4096;
  std::unordered_map<std::uint32_t, int> preemptions_;  // by candidate order
  std::unordered_map<std::uint32_t, std::shared_ptr<const Equilibrium>>
      partial_;  // by candidate order: last iterate of a cancelled solve
  double preemption_checked_ = 0, solve_seconds_;
  std::vector<double> recent_costs_, costs_;

  std::vector<Prediction> predicted_;
  std::vector<double> priorities_;
  std::vector<Ranked> ranked_;
  std::vector<Vec3> pending_;  // where states are being solved
  std::vector<DispatchRecord> dispatches_;
  StateCounts counts_;
  std::uint64_t audit_draws_ = 0;
  std::size_t jobs_ = 0, predictions_refused_ = 0;
  struct {
    std::size_t not_numbers = 0, infinite = 0, negative = 0;
  } priorities_refused_;
  std::size_t strays_ = 0, elsewhere_ = 0;  // results of no running job; results for another position
  std::vector<std::string> notes_;
};

}  // namespace forefeel
