#pragma once
// The open candidates and what each is worth now: what a planner solves next. With many idle workers, only the best
// candidates are ranked again after each dispatch. One thread owns it.

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scheduling/policy/candidates.hpp"
#include "scheduling/session/planner_setup.hpp"

namespace forefeel {

// What the priorities depend on besides states and candidates; constant during a planning step.
struct PlanMoment {
  double now = 0;  // [s]
  HipSample hip = {};
  double solve_seconds = 0;  // expected, without messages
  int workers = 1;
  std::span<const float> surprises = {};
  std::function<double(const Vec3&)> estimate = {};  // PlannerView::estimate
};

class Ranking {
 public:
  // future: the true motion, for policies that read it; may be empty. Setup and space must outlive it.
  Ranking(const PlannerSetup& setup, const StateSpace& space, std::function<Vec3(double)> future);

  Candidates& candidates() { return *candidates_; }

  // Before anything is ranked at this moment. pending: where states are being solved [m].
  void look(const PlanMoment& moment, std::vector<Vec3> pending);
  void pend(const Vec3& at) { pending_.push_back(at); }  // a job more; tell() follows
  void pend(std::vector<Vec3> pending);                  // another list; tells the policy
  void tell();                                           // tells the policy what is pending
  const std::vector<Vec3>& pending() const { return pending_; }
  double worth(const Candidate& candidate);  // its priority now

  struct Chosen {
    std::size_t place = 0;  // of the open candidates
    double priority = 0;
  };
  Chosen best();  // ranks all
  // Where the policy allows it, for several idle workers in one step: begin_many(), then best_of_many() for each.
  bool ranks_many() const;
  void begin_many();
  Chosen best_of_many();
  // After best(): the open candidates next to one.
  std::vector<Candidate> beside(std::size_t place) const;

  std::vector<std::string> complaints()
      const;  // what policy and predictor gave that is no number, a line each

 private:
  struct Ranked {  // in a heap, the best is on top
    double priority = 0;
    Candidate candidate;
    std::size_t pending = 0;  // number of pending positions when it was ranked
    friend bool operator<(const Ranked& a, const Ranked& b) {
      return a.priority != b.priority ? a.priority < b.priority : a.candidate.order > b.candidate.order;
    }
  };
  struct Refused {
    std::size_t not_numbers = 0, infinite = 0, negative = 0;  // priorities
    std::size_t predictions = 0;
  };
  void predict();
  Prediction checked(Prediction p);
  PlannerView view() const;
  double ranked_by(double priority);
  void rank();
  std::size_t first() const;

  const PlannerSetup& setup_;
  const StateSpace& space_;
  std::function<Vec3(double)> future_;
  std::unique_ptr<Candidates> candidates_;
  std::function<double(const Vec3&)> estimate_;  // by the candidates; empty: that of the moment
  PlanMoment moment_;
  std::vector<Prediction> predicted_;
  std::vector<Vec3> pending_;
  std::vector<double> priorities_;  // of the open candidates, by best() and begin_many()
  std::vector<Ranked> ranked_;
  Refused refused_;
};

}  // namespace forefeel
