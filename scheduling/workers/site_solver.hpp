#pragma once
// Solves states (s, x) of a body that is touched anywhere; one object per thread. x = 0 asks for the jet at rest. A
// solver of the last site is kept, so states of one site share its discretisation.
//
// A state is the equilibrium that straight continuation from rest reaches (Solver::reference). A solve from a
// neighbour, or from rest in one step, may end at another one. So its force is compared with that of the jet at rest of
// the site: unless they agree within the jet's own estimate or 1 %, the continuation is solved too, and its state
// counts. States keep a jet of order 4.

#include <memory>
#include <optional>
#include <stop_token>

#include "solver/equilibrium/solver.hpp"
#include "solver/jet/rest_sites.hpp"

namespace forefeel {

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
