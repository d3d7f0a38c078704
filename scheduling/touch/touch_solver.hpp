#pragma once
// Solves states (s, x) of a body that is touched anywhere; one object per thread. x = 0 asks for the jet at rest. A
// solver of the last site is kept, so states of one site share its discretisation.
//
// A state is the equilibrium that straight continuation from rest reaches (Solver::reference). A solve from a
// neighbour, or from rest in one step, may end at another one. So its force is compared with that of the jet at rest of
// the site: unless they agree within the jet's own estimate or 1 %, the continuation is solved too, and its state
// counts.

#include <deque>
#include <memory>
#include <optional>
#include <stop_token>

#include "solver/equilibrium/solver.hpp"
#include "solver/jet/rest_sites.hpp"

namespace forefeel {

struct TouchJob {
  std::uint32_t id = 0;
  SurfacePlace site;
  Vec3 x = Vec3::Zero();                          // [m]
  std::shared_ptr<const Equilibrium> start = {};  // of a state near (s, x); null: rest
};

struct TouchSolved {
  State state;  // with its site, and a jet of order 4
  std::shared_ptr<const Equilibrium> equilibrium = {};
};

// Solutions of states, from which neighbours start: the last ones.
class TouchStarts {
 public:
  void add(const SurfacePlace& site, std::shared_ptr<const Equilibrium> equilibrium);
  // The nearest of them to (s, x), where it is nearer than rest; else null. The pad moves with the site, so ways over
  // the surface count as ways of the tip.
  std::shared_ptr<const Equilibrium> near(const SurfacePlace& site, const Vec3& x) const;

 private:
  struct Start {
    SurfacePlace site;
    std::shared_ptr<const Equilibrium> equilibrium;
  };
  std::deque<Start> starts_;
};

class TouchSolver {
 public:
  TouchSolver(std::shared_ptr<const RestSites> sites, double step);  // of continuation [m]
  ~TouchSolver();
  TouchSolver(TouchSolver&&) noexcept;

  TouchSolved solve(const TouchJob& job, const std::stop_token& stop = {});
  State reference(const SurfacePlace& site, const Vec3& x);  // tight, from rest

 private:
  Solver& at(const SurfacePlace& site);
  bool is_expected(const SurfacePlace& site, const State& state);

  std::shared_ptr<const RestSites> sites_;
  double step_;
  SurfacePlace last_;
  std::unique_ptr<Solver> solver_;
  std::unique_ptr<SiteJets> jets_;
  std::optional<RestJet> rest_;  // of the last site
};

// As solver.solve(), with a failed state in place of an exception.
TouchSolved solved_by(TouchSolver& solver, const TouchJob& job, const std::stop_token& stop);

}  // namespace forefeel
