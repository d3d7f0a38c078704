#pragma once
// Static equilibrium of a body whose contact is held at x [m]: the displacements u [m] with
//   r(u) = dW/du = 0 on the free nodes,   u = 0 on the clamp,   u = x on the contact
//   f = -sum of dW/du over the contact nodes [N]     K = -df/dx = H_cc - H_cf H_ff^{-1} H_fc [N/m]
// W [J] stored energy, H = d2W/du2, f and c the free nodes and the contact. The residual is |r| / max(|f|,
// 1e-12 E L^2) with Young's modulus E of the stiffest material and the longest side L of the mesh.

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// A converged solution that later solves can start from; immutable, shared between threads.
struct Equilibrium {
  Vec3 at = Vec3::Zero();             // [m]
  std::vector<double> displacements;  // #V x 3 row by row [m]
  std::vector<double> tangent;        // du/dx, (#V x 3) x 3 row by row; may be empty
};

struct SolveOptions {
  double tolerance = 1e-10;  // on the relative residual
  int max_iterations = 60;   // Newton iterations in all
  double max_step = 0;       // continuation step [m]; 0: the whole way at once, halved where it fails
  bool want_displacements = false;
  int jet = 1;  // order of the force that a state keeps: with 2 to 4 also an energy jet
  // Reuses a factor while it contracts; K and du/dx are then corrected to about 1e-5.
  bool keep_factor = false;
};

struct SolveOutcome {
  State state;  // its status says how the solve ended; divergence does not throw
  std::shared_ptr<const Equilibrium> equilibrium;  // null unless converged
  // The last iterate of a cancelled solve. Not an equilibrium, but from() can start there.
  std::shared_ptr<const Equilibrium> partial;
  std::vector<std::string> warnings;
};

struct Discretisation;

// What the solvers of one body share: discretisation and symbolic factorisation, made by the thread that asks
// first. Any thread may call it.
class SolverBasis {
 public:
  explicit SolverBasis(std::shared_ptr<const Body> body);
  const std::shared_ptr<const Body>& body() const { return body_; }
  std::shared_ptr<const Discretisation> discretisation();
  // Upper bound of the memory of one Solver of this basis, without the basis, that makes jets of this order.
  std::size_t bytes_per_solver(int jet = 1);

 private:
  std::shared_ptr<const Body> body_;
  std::once_flag once_;
  std::shared_ptr<const Discretisation> discretisation_;
};

// Solves states of one body; one object per thread. It keeps the work space, and without a basis also the sparsity
// pattern and the symbolic factorisation. Results depend on the arguments alone, not on what was solved before.
class Solver {
 public:
  explicit Solver(std::shared_ptr<const Body> body);
  explicit Solver(Body body);
  explicit Solver(SolverBasis& basis);
  ~Solver();
  Solver(Solver&&) noexcept;
  Solver& operator=(Solver&&) noexcept;

  const Body& body() const;
  std::shared_ptr<const Equilibrium> rest() const;
  // Calls progress(share of the way) after each continuation step of reference() and from(); a linear body has no
  // steps.
  void watch(std::function<void(double)> progress);
  // On the reference branch (the primary equilibrium path): from rest straight to x in equal steps of at most `spacing`
  // [m], each solved to tolerance.
  SolveOutcome reference(const Vec3& x, double spacing, const SolveOptions& options = {});
  // From a known equilibrium in one step, or smaller ones if that fails. Checks `stop` between iterations.
  SolveOutcome from(const Equilibrium& start, const Vec3& x, const SolveOptions& options,
                    std::stop_token stop = {});
  // Solves states near a known equilibrium, eight at a time, with one factor computed there (or with that of the
  // last solve, if it ended there). This is much faster than single solves. A state is solved by from() instead if
  // its iteration does not contract, if its K does not converge, or if its force differs from the one that the
  // stiffnesses predict. Outcomes are in the order of xs; states not solved because of `stop` are cancelled.
  std::vector<SolveOutcome> beside(const Equilibrium& near, const std::vector<Vec3>& xs,
                                   const SolveOptions& options, std::stop_token stop = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// True if a second path, along the axes one after the other, ends at state.at in another stable equilibrium: one whose
// force differs by more than 1e-4 (relative). False also if the state is not solved or the second path fails on its
// way.
bool second_way_differs(Solver& solver, const State& state, double spacing, const SolveOptions& options = {});

}  // namespace forefeel
