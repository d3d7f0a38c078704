#pragma once
// A policy decides which state is solved next: it gives each candidate position a priority, and the planner dispatches
// the highest.
//
// To write one: derive from Policy, define name() and priority(), register it under a name.
//
//   struct Deepest final : forefeel::Policy {                     // farthest from rest first
//     std::string_view name() const override { return "deepest"; }
//     bool reads_regions() const override { return false; }       // Candidate::region is not used
//     double priority(const forefeel::Candidate& candidate, const forefeel::PlannerView&) const override {
//       return candidate.at.norm();
//     }
//   };
//   const bool known = (forefeel::register_policy("deepest", [](forefeel::FactoryContext&) {
//     return std::make_unique<Deepest>(); }), true);
//
// In code, options.planning.policy = Registered("deepest") then selects it. Scenes, studies and options
// know the name only in a command built with it (apps/examples/command_policy.cpp); `forefeel` itself is not.
// The built-in policies are in built_in_policies.cpp.
//
// Order of calls in each planning step (each frame under the virtual clock, about every millisecond under the
// real one): look() once; prioritise() for all candidates; after each dispatch pend(), then prioritise()
// again for the candidates that may be dispatched next. Preemption calls pend() and priority() for single
// candidates.
// Thread: the planner's alone. It may allocate, lock and throw; an exception ends the session early and is reported in
// SessionResult::failures. The time of a policy delays every decision: keep a step well below a millisecond. Under the
// virtual clock the result must depend only on the arguments of these calls and the seed, so that runs repeat bit by
// bit.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/common/factory_context.hpp"
#include "scheduling/motion/hip_sample.hpp"

namespace forefeel {

struct Declared;

// What a policy may read; constant during a call.
struct PlannerView {
  const StateSpace& space;
  double now = 0;  // [s]
  HipSample hip;
  std::span<const Prediction> predicted;  // by increasing horizon; the first is now
  double solve_seconds = 0.01;            // running median of a solve and its two messages [s]
  int workers = 1;
  std::span<const Vec3> pending;  // where states are being solved [m]
  bool with_stiffness = true;     // the model uses the stiffness of states, so each state reaches farther
  bool in_cells = false;  // the model interpolates in lattice cells and needs all corners of the HIP's cell
  // By state id, for policies that request it: the error that the model had at the state's position before
  // the state was known, divided by the JND of its force. NaN: not measured. May be shorter than the space.
  std::span<const float> surprises = {};
  // Of a model of energy jets: its own estimate of its error at a place, in JNDs, trust included. Empty for others.
  std::function<double(const Vec3&)> estimate = {};
};

struct Candidate {
  Vec3 at = Vec3::Zero();       // where a state would be solved: place of the tip [m]
  Label region = Label::blank;  // label of the region it lies in
  double requested = 0;         // when the HIP first came within 2.5 spacings [s]; infinite before
  double delta = 0;             // distance to the nearest known state [m]; infinite if none is known
  std::uint32_t order = 0;      // rank by distance from rest
  bool passing = false;         // placed for this planning step only
  SurfacePlace site = {};       // that the pad has there, where a body is touched anywhere; else none

  Vec3 displacement() const { return site.exists() ? Vec3(at - site.at) : at; }
};

// The positions that may become candidates.
enum class Placement {
  lattice,  // the points {k h}^3 in the box
  adaptive,  // the corners of an octree with leaves of width 4 h. If the predicted path enters a leaf whose corners
             // are known or being solved, the leaf is split, down to width h
  path  // every second lattice point along each axis, and points of the predicted path, chosen again in each
        // planning step. None is nearer than h / 2 to a state that is known or being solved
};

class Policy {
 public:
  virtual ~Policy() = default;
  virtual std::string_view name() const = 0;
  // Called once per planning step, before the candidates are ranked. Do work shared by all candidates here.
  virtual void look(const PlannerView&) {}
  // Called when only `pending` has changed: more states are being solved, or one was removed temporarily to compute
  // the present priority of its job.
  virtual void pend(const PlannerView&) {}
  // Whether Candidate::region is used. Updating the labels of all candidates costs more than ranking them.
  virtual bool reads_regions() const { return true; }
  // Whether PlannerView::surprises is used. Each of them costs a model fit.
  virtual bool reads_surprises() const { return false; }
  // After look(): whether no candidate is worth a solve. The workers then stay idle until the next step.
  virtual bool is_content() const { return false; }
  // Whether PlannerView::predicted must hold the true motion instead of a prediction. This requires a motion
  // that does not depend on the force; the session refuses other devices.
  virtual bool reads_future() const { return false; }
  // The worth of solving the candidate next: finite, at least 0; the largest is solved first. Preemption compares
  // ratios of priorities. Other values do not end the session: they are sorted by <, NaN last; a note says how many.
  virtual double priority(const Candidate& candidate, const PlannerView& view) const = 0;
  // Upper bound of a candidate's priority after more states became pending in the same step; `priority` is its present
  // one. A larger argument must not give a smaller result. If it returns the priority itself, only the best candidates
  // are ranked again. If it returns infinity, all candidates are ranked again.
  virtual double at_most(double priority) const;
  // The priorities of all candidates of a planning step; override it if they share work. Writes #candidates
  // values.
  virtual void prioritise(std::span<const Candidate> candidates, const PlannerView& view,
                          std::span<double> out) const;
};

// The policy of a session: a name and the settings behind it.
using PolicySpec = Registered;
using PolicyFactory = std::function<std::unique_ptr<Policy>(FactoryContext&)>;

// May be called from any thread, and before main() begins. InputError for a name that is taken.
// The factory is called several times for a session, to check it and to run it, from the threads of make_plan() and
// run_session(). What it throws becomes an InputError that names the policy.
void register_policy(const std::string& name, PolicyFactory factory);
std::vector<std::string> policy_names();  // sorted
// A policy without information, as a floor: "random", or one whose labels or estimates are permuted ("shuffled" …).
bool is_placebo(std::string_view policy);
std::vector<Declared> declared_policies();  // with their meanings, for `forefeel help`
// Throws InputError for an unknown name; the error lists the known ones.
std::unique_ptr<Policy> make_policy(const PolicySpec& policy, const FactoryContext& context = {});

// Soonest time at which the HIP may be at a position [s]: the minimum over the predicted path of
//   horizon + 2 distance / speed
// The factor 2 allows for the turn off the path. Speeds below 10 mm/s count as 10 mm/s.
double time_to_reach(const Vec3& at, const PlannerView& view);
// Distance from a position to the predicted path [m].
double distance_to_path(const Vec3& at, const PlannerView& view);

}  // namespace forefeel
