#pragma once
// What is solved next: a policy gives every candidate position a priority; the planner dispatches the highest.
// A policy of one's own is one file: derive, register, name it in the scene.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/motion/hip_sample.hpp"

namespace forefeel {

// What a policy may look at; immutable while it is asked.
struct PlannerView {
  const StateSpace& space;
  double now = 0;  // [s]
  HipSample hip;
  std::span<const Prediction> predicted;  // by growing horizon, first is now
  double solve_seconds = 0.01;            // running median of a solve [s]
  int workers = 1;
  std::span<const Vec3> pending;  // where states are being solved [m]
  bool with_stiffness = true;     // the model uses the stiffness of states: each reaches farther
  bool in_cells = false;          // it interpolates in lattice cells, and needs all corners of the HIP's
  // By state id, for policies that ask: how far the model of the states before it was from the state when it came,
  // over the JND of its force; NaN where nobody looked. May be shorter than the space.
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
  // Called once before the candidates of a planning step are ranked: the place for what is the same for all of them.
  virtual void look(const PlannerView&) {}
  // Nothing but `pending` changed since then: more was given out, or a job is weighed as if it were not.
  virtual void pend(const PlannerView&) {}
  // Whether Candidate::region is asked for; keeping the labels of all candidates costs more than ranking them.
  virtual bool reads_regions() const { return true; }
  // Whether PlannerView::surprises is asked for; each costs a fit.
  virtual bool reads_surprises() const { return false; }
  // The worth of solving the candidate next: finite, not negative, larger is sooner. Preemption compares ratios.
  virtual double priority(const Candidate& candidate, const PlannerView& view) const = 0;
  // The most that a candidate of this priority can be worth once more is pending in the same step; never falls as the
  // priority grows. Where it is the priority itself only the best are ranked again. Infinite: nothing is known, all are.
  virtual double at_most(double priority) const;
  // All candidates of a planning step at once; override where they share work. Writes #candidates values.
  virtual void prioritise(std::span<const Candidate> candidates, const PlannerView& view,
                          std::span<double> out) const;
};

struct PolicyOptions {
  std::uint64_t seed = 0;
};
using PolicyFactory = std::function<std::unique_ptr<Policy>(const PolicyOptions&)>;
void register_policy(std::string name, PolicyFactory factory);
std::vector<std::string> policy_names();
std::unique_ptr<Policy> make_policy(const std::string& name,
                                    const PolicyOptions& options);  // InputError lists names
// True for the policy whose predictions are the motion itself, as far as the session knows it.
bool knows_the_future(const std::string& name);

// Soonest time at which the HIP may be at a position: min over the predicted path of horizon + 2 distance / speed,
// since leaving the path takes a turn; the speed no less than 10 mm/s [s].
double time_to_reach(const Vec3& at, const PlannerView& view);
// Distance from a position to the predicted path [m].
double distance_to_path(const Vec3& at, const PlannerView& view);

}  // namespace forefeel
