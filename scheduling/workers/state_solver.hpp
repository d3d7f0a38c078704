#pragma once
// Solves states of one body in one thread. It uses a Solver, whose analysis all threads share; for a linear
// body, it superposes three states that all threads share (solver/equilibrium/linear_body.hpp). Of a body that is
// touched anywhere, each state has a site (SiteSolver).

#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "scheduling/workers/generator.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/jet/rest_sites.hpp"

namespace forefeel {

class LinearBasis;
class SiteSolver;

class StateSolver {
 public:
  using Options = StateSolverOptions;
  // linear: null unless the body is linear.
  StateSolver(std::shared_ptr<SolverBasis> basis, std::shared_ptr<LinearBasis> linear, Options options);
  ~StateSolver();
  StateSolver(StateSolver&&) noexcept;

  void prepare();  // symbolic factorisation, before the first job
  // Tight, on the reference branch.
  SolveOutcome reference(const Vec3& x, const SurfacePlace& site = {});
  // Solves from a known solution (null: rest); if that fails, along the reference branch.
  SolveOutcome from(const Equilibrium* start, const Vec3& x, std::stop_token stop,
                    const SurfacePlace& site = {});
  // Solves neighbours of a state just solved; those that fail are solved by from().
  std::vector<SolveOutcome> beside(const Equilibrium* near, const std::vector<Vec3>& xs,
                                   std::stop_token stop);

 private:
  SolveOptions quick() const;
  SolveOutcome linear_outcome(const Vec3& x);
  void settle(SolveOutcome& outcome, const Vec3& x, const std::stop_token& stop);
  Solver& solver();  // made at the first use: a cached run never needs one
  std::shared_ptr<SolverBasis> basis_;
  std::shared_ptr<LinearBasis> linear_;
  Options options_;
  std::optional<Solver> solver_;
  std::unique_ptr<SiteSolver> at_sites_;  // null: the contact has one place
};

// Solves states (s, x) of a body that is touched anywhere; one object per thread. x = 0 asks for the jet at rest. A
// solver of the last site is kept, so states of one site share its discretisation.
//
// A state is the equilibrium that straight continuation from rest reaches (Solver::reference). A solve from a
// neighbour, or from rest in one step, may end at another one. So its force is compared with that of the jet at rest of
// the site: unless they agree within the jet's own estimate or 1 %, the continuation is solved too, and its state
// counts. States keep a jet of order 4.

class SiteSolver {
 public:
  SiteSolver(std::shared_ptr<const RestSites> sites, double step,
             bool displacements);  // step of continuation [m]
  ~SiteSolver();

  // start: of a state near (s, x); null: rest.
  SolveOutcome solve(const SurfacePlace& site, const Vec3& x, const Equilibrium* start,
                     const std::stop_token& stop);
  SolveOutcome reference(const SurfacePlace& site, const Vec3& x);  // tight, from rest

 private:
  Solver& at(const SurfacePlace& site);
  const RestJet& rest(const SurfacePlace& site);
  SolveOutcome at_rest(const SurfacePlace& site);
  bool is_expected(const SurfacePlace& site, const State& state);

  std::shared_ptr<const RestSites> sites_;
  double step_;
  bool displacements_;
  SurfacePlace last_;
  std::unique_ptr<Solver> solver_;
  std::unique_ptr<SiteJets> jets_;
  std::optional<RestJet> rest_;  // of the site rest_of_
  SurfacePlace rest_of_;
};

}  // namespace forefeel
