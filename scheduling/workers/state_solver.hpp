#pragma once
// Solves states of one body in one thread. It uses a Solver, whose analysis all threads share; for a linear
// body, it superposes three states that all threads share (solver/equilibrium/linear_body.hpp). Of a body that is
// touched anywhere, each state has a site (site_solver.hpp).

#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "scheduling/workers/generator.hpp"
#include "solver/equilibrium/solver.hpp"

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

}  // namespace forefeel
