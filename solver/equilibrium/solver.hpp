#pragma once
// Static equilibrium of a body whose contact is held at x: find u with r(u) = dW/du = 0 on the free nodes,
// u = 0 on the clamp, u = x on the contact. Force f = -sum of dW/du over the contact nodes; condensed stiffness
// K = -df/dx = H_cc - H_cf H_ff^{-1} H_fc. Residual reported: |r| / max(|f|, 1e-12 E L^2).

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// A converged solution that later solves can start from; immutable, shared between threads.
struct Equilibrium {
  Vec3 at = Vec3::Zero();
  std::vector<double> displacements;  // #V x 3 row by row [m]
  std::vector<double> tangent;        // du/dx, (#V x 3) x 3 row by row; may be empty
};

struct SolveOptions {
  double tolerance = 1e-10;  // on the relative residual
  int max_iterations = 60;   // Newton iterations in all
  double max_step = 0;       // continuation step [m]; 0: the whole way at once, halved where it fails
  bool want_displacements = false;
  bool keep_factor = false;  // serves on while it contracts; K and du/dx are then corrected, to about 1e-5
};

struct SolveOutcome {
  State state;                                     // status says how it ended; never throws for divergence
  std::shared_ptr<const Equilibrium> equilibrium;  // null unless converged
  // Cancelled after some iterations: where they stood. Not in equilibrium, but a start for from() all the same.
  std::shared_ptr<const Equilibrium> partial;
  std::vector<std::string> warnings;
};

// Keeps the pattern, symbolic factorisation and work space of one body; one per thread. Results depend on the
// arguments alone, not on what was solved before.
class Solver {
 public:
  explicit Solver(std::shared_ptr<const Body> body);
  ~Solver();
  Solver(Solver&&) noexcept;
  Solver& operator=(Solver&&) noexcept;

  const Body& body() const;
  std::shared_ptr<const Equilibrium> rest() const;
  // From rest straight to x in steps <= spacing, each tight: the reference branch.
  SolveOutcome reference(const Vec3& x, double spacing, const SolveOptions& options = {});
  // From a known equilibrium, directly; falls back to smaller steps. stop is looked at between iterations.
  SolveOutcome from(const Equilibrium& start, const Vec3& x, const SolveOptions& options,
                    std::stop_token stop = {});
  // States near a known equilibrium, eight side by side on one factor there (the last solve's, if that was it): a
  // fraction of the time of as many single solves. What does not contract, whose K does not settle or whose force is not
  // what the stiffnesses between foretell is solved by from(). In the order of xs; what stop prevented is cancelled.
  std::vector<SolveOutcome> beside(const Equilibrium& near, const std::vector<Vec3>& xs,
                                   const SolveOptions& options, std::stop_token stop = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Whether a second way, along the axes one after the other instead of straight, ends in another stable equilibrium at
// state.at: its force differs by more than 1e-4. Nothing where the state is not solved or the second way does not arrive.
std::optional<bool> second_way(Solver& solver, const State& state, double spacing,
                               const SolveOptions& options = {});
// False where that is not known.
bool second_way_differs(Solver& solver, const State& state, double spacing, const SolveOptions& options = {});

}  // namespace forefeel
