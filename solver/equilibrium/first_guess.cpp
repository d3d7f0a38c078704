#include "solver/equilibrium/first_guess.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>

#include "geometry/common/dense.hpp"
#include "geometry/states/state.hpp"
#include "solver/body/contact_stiffness.hpp"
#include "solver/body/refined_body.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/system/factorisation.hpp"

namespace forefeel {
namespace {

// The largest eigenvalue of the disc's stiffness relative to K; unknown unless both are positive definite.
double softness_of(const Mat3& stiffness, const Mat3& disc) {
  const Eigen::LLT<Mat3> root(stiffness);
  if (root.info() != Eigen::Success || disc.isZero(0)) return unknown;
  const Mat3 whitened = root.matrixL().solve(root.matrixL().solve(disc).transpose());
  return axes_of(whitened).values[2];
}

}  // namespace

FirstGuess first_guess(const std::shared_ptr<const Body>& body) {
  FirstGuess guess{.softness = unknown};
  if (const std::int64_t nodes = estimated_nodes(*body); nodes > most_guess_nodes) {
    guess.left_out = fmt::format("the body has {} nodes, more than {}", nodes, most_guess_nodes);
    return guess;
  }
  SolverBasis basis(body);
  if (const double work = cost_of_factor(*basis.discretisation()).flops; work > most_guess_work) {
    guess.left_out = fmt::format("a factorisation of the body takes {:.2g} multiplications, more than {:.2g}",
                                 work, most_guess_work);
    return guess;
  }
  const State rest = Solver(basis).reference(Vec3::Zero(), 1).state;
  if (!rest.usable() || !rest.has_stiffness()) {
    guess.left_out = "the body has no stable equilibrium at rest";
    return guess;
  }
  guess.stiffness = 0.5 * (rest.stiffness + rest.stiffness.transpose());
  guess.softness = softness_of(guess.stiffness, disc_stiffness(*body));
  return guess;
}

}  // namespace forefeel
