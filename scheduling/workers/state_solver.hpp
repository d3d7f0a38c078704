#pragma once
// Solves states of one body for one thread: a Solver, or for a linear body the three solves that give its whole
// state space, f(x) = -K x, shared by all threads.

#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

#include "solver/equilibrium/solver.hpp"

namespace forefeel {

// Displacements and stiffness of a linear body, made by whichever thread asks first.
class LinearBasis {
 public:
  LinearBasis(std::shared_ptr<const Body> body, double spacing) : body_(std::move(body)), spacing_(spacing) {}
  SolveOutcome at(const Vec3& x, bool want_displacements);

 private:
  void solve();
  std::shared_ptr<const Body> body_;
  double spacing_;
  std::once_flag once_;
  SolveStatus status_ = SolveStatus::diverged;
  Mat3 stiffness_ = Mat3::Zero();
  std::vector<double> displacements_[3];  // per unit of each axis, #V x 3 row by row
  double residual_ = 0, seconds_ = 0;
  int iterations_ = 0;
};

struct StateSolverOptions {
  double spacing = 0.006;   // continuation step of the reference branch [m]
  double tolerance = 1e-6;  // of from()
  bool displacements = false;
};

class StateSolver {
 public:
  using Options = StateSolverOptions;
  // linear: null unless is_linear(*body).
  StateSolver(std::shared_ptr<const Body> body, std::shared_ptr<LinearBasis> linear, Options options);

  void prepare();                         // lays out the factor before the first job
  SolveOutcome reference(const Vec3& x);  // tight, on the reference branch
  // From a known solution (null: rest); the reference branch where that fails.
  SolveOutcome from(const Equilibrium* start, const Vec3& x, std::stop_token stop);
  // Neighbours of one just solved; those that fail as from().
  std::vector<SolveOutcome> beside(const Equilibrium* near, const std::vector<Vec3>& xs,
                                   std::stop_token stop);

 private:
  SolveOptions quick() const;
  void settle(SolveOutcome& outcome, const Vec3& x, const std::stop_token& stop);
  Solver& solver();  // made at the first use: a cached run never needs one
  std::shared_ptr<const Body> body_;
  std::shared_ptr<LinearBasis> linear_;
  Options options_;
  std::optional<Solver> solver_;
};

std::shared_ptr<LinearBasis> linear_basis(const std::shared_ptr<const Body>& body,
                                          double spacing);  // or null

}  // namespace forefeel
