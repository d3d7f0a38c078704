#pragma once
// The obvious way to solve a state, to be compared with: full Newton on a general sparse Cholesky factorisation,
// warm-started from a neighbour with the contact's move folded into the first step, refactorised in every iteration,
// with force, condensed stiffness and energy like ours. Element kernels are the same for both sides, and so is the
// instruction set: the Eigen version is compiled once for each.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/system/discretisation.hpp"

namespace forefeel {

// A sparse symmetric positive definite solver. Lower triangle by columns, n x n; values in the order of `row`.
struct SparsePattern {
  int n = 0;
  std::vector<int> start, row;
};
struct SparseSolver {
  virtual ~SparseSolver() = default;
  virtual bool factor(const double* values) = 0;
  virtual void solve(const double* b, double* x) = 0;
};

std::unique_ptr<SparseSolver> make_eigen_ldlt(
    const SparsePattern& pattern);  // of this processor's instruction set
std::unique_ptr<SparseSolver> make_cholmod(const SparsePattern& pattern);
std::string cholmod_blas();  // the BLAS it runs on, its kernels and threads
// The OPENBLAS_CORETYPE of this processor's instruction set where OpenBLAS chose lesser kernels, or null.
const char* cholmod_blas_wanted();

enum class Baseline { eigen_ldlt, cholmod };

class BaselineNewton {
 public:
  BaselineNewton(std::shared_ptr<const Discretisation> discretisation, Baseline which);
  // u: the neighbour's equilibrium (local vector); becomes that at x.
  State solve(std::vector<double>& u, const Vec3& x, double tolerance, int max_iterations = 30);

 private:
  bool factorise(const std::vector<double>& u);
  void copy_values();

  std::shared_ptr<const Discretisation> d_;
  SparsePattern pattern_;
  std::vector<std::int64_t> source_;  // of each value, in the block values
  std::unique_ptr<SparseSolver> solver_;
  std::vector<double> blocks_, values_, gradient_, right_, step_;
};

}  // namespace forefeel
