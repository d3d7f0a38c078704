#pragma once
// Decides what is solved next where a body is touched anywhere. The predictor says where the tip will be; the touch, or
// the place where the predicted way enters the body, says at which site. Of each predicted (s, x) two kinds of states
// are wanted:
//   a jet at rest at s itself, if none is known within a quarter of site_spacing; these come first
//   states at lattice points {k h} of the tip near s + x, where the model's own estimate of its error is above the
//   tolerance; the policy ranks them
// Policies, labels of candidates and pending states are in the space of the tip, p = s + x: the metric is |p - p'|.
// Sites that are no neighbours never share a tip unless a lobe is pressed through.

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "scheduling/motion/predictor.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/touch/touch_link.hpp"
#include "scheduling/touch/touch_records.hpp"
#include "scheduling/touch/touch_solver.hpp"

namespace forefeel {

// What is known of the body and wanted of its states.
struct TouchTask {
  std::shared_ptr<const SiteField> field;
  std::shared_ptr<const SurfaceGrid> grid;
  std::shared_ptr<const FieldPatches> patches;  // of the field
  StateSpaceOptions tips;                       // box of the body, h
  double depth = 0.025;                         // of states [m]
  std::optional<double> friction;               // coefficient
  double tolerance = 0.07;                      // of the relative error [1]
  double floor = 0.05;                          // f0 [N]
};

struct TouchPlannerParts {
  std::unique_ptr<Policy> policy;
  std::unique_ptr<Predictor> predictor;
  int workers = 1;
  double solve_seconds = 0.01;              // expected at first [s]
  std::function<Vec3(double)> future = {};  // the true motion by time [s], for policies that read it
};

class TouchPlanner {
 public:
  TouchPlanner(TouchTask task, TouchPlannerParts parts, std::vector<State> known);

  void observe(const TouchSeen& seen);
  // Jobs for these idle workers, best first; at most one each.
  std::vector<TouchJob> plan(const std::vector<int>& idle, double now);
  // Where no worker is idle: one whose running solve another is worth twenty times of, or a jet at rest at the hand's
  // place is waited for. No state is cancelled more than twice. The caller cancels it.
  std::optional<int> preempted(double now);
  // Of a job that plan() gave. Returns whether there is something new to render.
  bool receive(std::uint32_t id, TouchSolved solved, double started, double finished, double now);
  // The model of all that is known; it lives as long as the planner.
  const TouchModel* model();
  // By serial number - 1.
  std::vector<std::shared_ptr<const DeepStates>> models() const;

  const std::vector<State>& known() const { return known_; }  // in the order in which they became known
  const std::vector<TouchDispatch>& dispatches() const { return dispatches_; }
  std::size_t failed() const { return failed_count_; }

 private:
  struct Visit {
    SurfacePlace site;
    Vec3 x = Vec3::Zero();
  };
  struct Wanted {
    SurfacePlace site;
    Vec3 x = Vec3::Zero();
    Candidate candidate;  // in the space of the tip
  };
  using Key = std::array<std::int32_t, 6>;  // cells of the tip and of the site

  void predict();
  std::vector<Visit> visits() const;
  std::optional<SurfacePlace> missing_jet(const std::vector<Visit>& visits) const;
  std::vector<Wanted> candidates(const std::vector<Visit>& visits, double now);
  bool in_region(const Visit& visit, const Vec3& normal) const;
  bool near_jet(const SurfacePlace& site) const;
  Key key_of(const SurfacePlace& site, const Vec3& tip) const;
  TouchJob dispatch(const SurfacePlace& site, const Vec3& x, double priority, int worker, double now);
  PlannerView view(double now) const;
  double estimated_jnds(const Vec3& tip) const;
  void learn(const State& state);

  TouchTask task_;
  TouchPlannerParts parts_;
  FieldOfSites field_;
  StateSpace tips_;
  TouchSeen seen_;
  std::vector<Prediction> predicted_;
  std::vector<Visit> pressed_;        // where the tip will press
  std::vector<State> known_, fresh_;  // fresh_: not in a model yet
  std::vector<SurfacePlace> jets_;    // places with a jet at rest, known or being made
  std::map<Key, double> asked_;       // when a candidate was first wanted [s]
  std::map<Key, bool> gone_;          // known, being solved or failed
  std::vector<Vec3> pending_;
  TouchStarts starts_;
  struct Preemption {
    double checked = 0;           // [s]
    std::map<Key, int> counts;    // how often each was cancelled
    std::set<std::uint32_t> now;  // dispatches that are told to stop
  };
  Preemption preemption_;
  std::vector<TouchDispatch> dispatches_;
  std::vector<SurfacePlace> places_;  // by dispatch
  std::vector<std::unique_ptr<TouchModel>> models_;
  std::vector<double> times_;  // of solves [s]
  std::size_t failed_count_ = 0;
};

}  // namespace forefeel
