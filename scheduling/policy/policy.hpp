#pragma once
// What is solved next: a policy gives every candidate position a priority; the planner dispatches the highest.
//
// To write one: derive from Policy, define name() and priority(), register it under a name.
//
//   struct Deepest final : forefeel::Policy {                     // what lies farthest from rest first
//     std::string_view name() const override { return "deepest"; }
//     bool reads_regions() const override { return false; }       // Candidate::region is not used: saves time
//     double priority(const forefeel::Candidate& candidate, const forefeel::PlannerView&) const override {
//       return candidate.at.norm();
//     }
//   };
//   const bool known = (forefeel::register_policy("deepest", [](forefeel::FactoryContext&) {
//     return std::make_unique<Deepest>(); }), true);
//
// Scenes (session.policy), studies and --policy then know it. The built-in ones are one file each, policy_NAME.cpp.
//
// Order of calls, in each planning step (each frame under the virtual clock, about every millisecond under the real one):
// look() once; prioritise() for all candidates; after each dispatch pend(), then prioritise() again for those that may be
// dispatched next. Preemption asks pend() and priority() for single candidates.
// Thread: the planner's alone. It may allocate, but its time delays every decision: keep a step well below a millisecond.
// Under the virtual clock it must be a function of what it was shown and the seed, so that a run repeats bit by bit.

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

// What a policy may look at; immutable while it is asked.
struct PlannerView {
  const StateSpace& space;
  double now = 0;  // [s]
  HipSample hip;
  std::span<const Prediction> predicted;  // by growing horizon, the first is now
  double solve_seconds = 0.01;            // running median of a solve and its two messages [s]
  int workers = 1;
  std::span<const Vec3> pending;  // where states are being solved [m]
  bool with_stiffness = true;     // the model uses the stiffness of states: each state reaches farther
  bool in_cells = false;  // the model interpolates in lattice cells and needs all corners of the HIP's cell
  // By state id, for policies that ask: error of the model of the earlier states at the position of this state, over the
  // JND of its force. NaN where it was not measured. May be shorter than the space.
  std::span<const float> surprises = {};
};

struct Candidate {
  Vec3 at = Vec3::Zero();       // where a state would be solved [m]
  Label region = Label::blank;  // label of the region it lies in
  double requested = 0;         // when the HIP first came within 2.5 spacings; infinite until then [s]
  double delta = 0;             // distance to the nearest known state; infinite while none is known [m]
  std::uint32_t order = 0;      // outward from rest
  bool passing = false;         // placed for this planning step alone
};

class Policy {
 public:
  virtual ~Policy() = default;
  virtual std::string_view name() const = 0;
  // Called once a planning step, before its candidates are ranked: the place for work that all of them share.
  virtual void look(const PlannerView&) {}
  // Only `pending` has changed since the last call: more states are being solved, or one is left out to weigh its job.
  virtual void pend(const PlannerView&) {}
  // Whether Candidate::region is used. Keeping the labels of all candidates costs more than ranking them.
  virtual bool reads_regions() const { return true; }
  // Whether PlannerView::surprises is used. Each of them costs a model fit.
  virtual bool reads_surprises() const { return false; }
  // Whether PlannerView::predicted is to hold the motion itself instead of a prediction. Only possible where the motion
  // does not depend on the force; the session refuses other devices.
  virtual bool reads_future() const { return false; }
  // The worth of solving the candidate next: finite, not negative, larger is sooner. Preemption compares ratios.
  virtual double priority(const Candidate& candidate, const PlannerView& view) const = 0;
  // Upper bound of the priority that a candidate of this priority can have once more is pending in the same step. Must
  // not fall as the priority grows. Where it is the priority itself, only the best candidates are ranked again. Infinite:
  // nothing is known, and all are ranked again.
  virtual double at_most(double priority) const;
  // All candidates of a planning step at once; override where they share work. Writes #candidates values.
  virtual void prioritise(std::span<const Candidate> candidates, const PlannerView& view,
                          std::span<double> out) const;
};

// The policy of a session: a name and the settings behind it.
using PolicySpec = Registered;
using PolicyFactory = std::function<std::unique_ptr<Policy>(FactoryContext&)>;

// From any thread and also before main() begins. InputError for a name that is taken.
void register_policy(const std::string& name, PolicyFactory factory);
std::vector<std::string> policy_names();  // sorted
// InputError lists the names.
std::unique_ptr<Policy> make_policy(const PolicySpec& policy, const FactoryContext& context = {});

// Soonest time at which the HIP may be at a position [s]: the minimum over the predicted path of
//   horizon + 2 distance / speed
// Leaving the path takes a turn, hence the 2; the speed counts as at least 10 mm/s.
double time_to_reach(const Vec3& at, const PlannerView& view);
// Distance from a position to the predicted path [m].
double distance_to_path(const Vec3& at, const PlannerView& view);

}  // namespace forefeel
