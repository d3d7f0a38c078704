#pragma once
// The textbook way to solve a state, for comparison: full Newton with a general sparse Cholesky factorisation,
//   H(u) d = -r(u),   u <- u + d     until |r| / |f| is small enough
// r [N]: residual, H [N/m]: its tangent, factorised in every iteration, u [m]: displacements, f [N]: force. It starts
// from a neighbour's equilibrium; the first step includes the displacement of the contact. Like Solver, it returns
// force [N], condensed stiffness [N/m] and energy [J]. Both use the same element kernels and the same instruction set;
// the Eigen version is compiled once for each instruction set.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/system/discretisation.hpp"

namespace forefeel {

// A sparse symmetric positive definite solver. Lower triangle by columns, n x n; values in the order of
// `row`.
struct SparsePattern {
  int n = 0;
  std::vector<int> start, row;
};
struct SparseSolver {
  virtual ~SparseSolver() = default;
  virtual bool factor(const double* values) = 0;
  virtual void solve(const double* b, double* x) = 0;
  virtual double factor_bytes() const = 0;  // after factor(); NaN: not known
};

std::unique_ptr<SparseSolver> make_eigen_ldlt(
    const SparsePattern& pattern);  // of this processor's instruction set
std::unique_ptr<SparseSolver> make_cholmod(const SparsePattern& pattern);
// The BLAS it runs on, its kernels and threads. Of CHOLMOD itself and of OpenBLAS only one thread works for a solver.
std::string cholmod_blas();
// OpenBLAS picks its kernels while it is loaded, and old ones on processors that it does not know, such as virtual
// ones. If they are below our instruction set, this sets the choice and restarts the command.
void match_blas_to_processor();

enum class Baseline { eigen_ldlt, cholmod };

class BaselineNewton {
 public:
  BaselineNewton(std::shared_ptr<const Discretisation> discretisation, Baseline which);
  // u: in, the neighbour's equilibrium (local vector); out, the equilibrium at x.
  State solve(std::vector<double>& u, const Vec3& x, double tolerance, int max_iterations = 30);
  bool factorise(const std::vector<double>& u);  // assembles H(u); false: it is not positive definite
  double factor_bytes() const { return solver_->factor_bytes(); }

 private:
  std::shared_ptr<const Discretisation> d_;
  SparsePattern pattern_;
  std::vector<std::int64_t> source_;  // of each value, in the block values
  std::unique_ptr<SparseSolver> solver_;
  std::vector<double> blocks_, values_, gradient_, right_, step_;
};

}  // namespace forefeel
