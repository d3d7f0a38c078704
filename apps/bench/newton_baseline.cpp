#include "apps/bench/newton_baseline.hpp"

#include <cholmod.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>

#include "geometry/common/instruction_set.hpp"

extern "C" {
char* openblas_get_config() __attribute__((weak));
char* openblas_get_corename() __attribute__((weak));
void openblas_set_num_threads(int) __attribute__((weak));
}

namespace forefeel {

FOREFEEL_IN_EACH_SET(void* make_ldlt(int, const int*, const int*); void free_ldlt(void*);
                     bool factor_ldlt(void*, const double*); void solve_ldlt(void*, const double*, double*);)

namespace {

struct LdltFunctions {
  void* (*make)(int, const int*, const int*);
  void (*free)(void*);
  bool (*factor)(void*, const double*);
  void (*solve)(void*, const double*, double*);
};

LdltFunctions ldlt_functions() {
  return {FOREFEEL_CHOSEN(make_ldlt), FOREFEEL_CHOSEN(free_ldlt), FOREFEEL_CHOSEN(factor_ldlt),
          FOREFEEL_CHOSEN(solve_ldlt)};
}

class EigenSolver : public SparseSolver {
 public:
  explicit EigenSolver(const SparsePattern& p)
      : functions_(ldlt_functions()), ldlt_(functions_.make(p.n, p.start.data(), p.row.data())) {}
  ~EigenSolver() override { functions_.free(ldlt_); }
  EigenSolver(const EigenSolver&) = delete;
  EigenSolver& operator=(const EigenSolver&) = delete;
  bool factor(const double* values) override { return functions_.factor(ldlt_, values); }
  void solve(const double* b, double* x) override { functions_.solve(ldlt_, b, x); }
  double factor_bytes() const override { return std::numeric_limits<double>::quiet_NaN(); }

 private:
  LdltFunctions functions_;
  void* ldlt_;
};

// CHOLMOD opens teams of four threads for its own loops, which cost more than they bring beside our workers. No team is
// opened while this lives.
class OneThread {
 public:
  OneThread() : levels_(omp_get_max_active_levels()) { omp_set_max_active_levels(omp_get_active_level()); }
  ~OneThread() { omp_set_max_active_levels(levels_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int levels_;
};

class CholmodSolver : public SparseSolver {
 public:
  explicit CholmodSolver(const SparsePattern& p) {
    if (openblas_set_num_threads) openblas_set_num_threads(1);
    cholmod_start(&common_);
    common_.print = 0;
    const auto n = static_cast<std::size_t>(p.n);
    matrix_ = cholmod_allocate_sparse(n, n, p.row.size(), 1, 1, -1, CHOLMOD_REAL, &common_);
    std::copy(p.start.begin(), p.start.end(), static_cast<int*>(matrix_->p));
    std::copy(p.row.begin(), p.row.end(), static_cast<int*>(matrix_->i));
    std::fill_n(static_cast<double*>(matrix_->x), p.row.size(), 0.0);
    const OneThread one;
    factor_ = cholmod_analyze(matrix_, &common_);
    right_ = cholmod_allocate_dense(n, 1, n, CHOLMOD_REAL, &common_);
  }
  ~CholmodSolver() override {
    cholmod_free_dense(&right_, &common_);
    cholmod_free_factor(&factor_, &common_);
    cholmod_free_sparse(&matrix_, &common_);
    cholmod_finish(&common_);
  }
  CholmodSolver(const CholmodSolver&) = delete;
  CholmodSolver& operator=(const CholmodSolver&) = delete;

  bool factor(const double* values) override {
    std::copy_n(values, matrix_->nzmax, static_cast<double*>(matrix_->x));
    const OneThread one;
    cholmod_factorize(matrix_, factor_, &common_);
    return common_.status == CHOLMOD_OK && factor_->minor == factor_->n;
  }
  void solve(const double* b, double* x) override {
    std::copy_n(b, matrix_->nrow, static_cast<double*>(right_->x));
    const OneThread one;
    cholmod_dense* result = cholmod_solve(CHOLMOD_A, factor_, right_, &common_);
    std::copy_n(static_cast<const double*>(result->x), matrix_->nrow, x);
    cholmod_free_dense(&result, &common_);
  }
  double factor_bytes() const override {
    if (!factor_->is_super) return 12.0 * static_cast<double>(factor_->nzmax);
    return 8.0 * static_cast<double>(factor_->xsize) + 4.0 * static_cast<double>(factor_->ssize);
  }

 private:
  cholmod_common common_;
  cholmod_sparse* matrix_ = nullptr;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* right_ = nullptr;
};

}  // namespace

std::unique_ptr<SparseSolver> make_eigen_ldlt(const SparsePattern& p) {
  return std::make_unique<EigenSolver>(p);
}
std::unique_ptr<SparseSolver> make_cholmod(const SparsePattern& p) {
  return std::make_unique<CholmodSolver>(p);
}

std::string cholmod_blas() {
  if (!openblas_get_config) return "reference BLAS";
  std::string version = openblas_get_config();  // "OpenBLAS 0.3.21 …"
  version = version.substr(0, version.find(' ', version.find(' ') + 1));
  return version + (openblas_get_corename ? std::string(", ") + openblas_get_corename() + " kernels" : "") +
         ", one thread, and CHOLMOD on one";
}

namespace {

// The value of OPENBLAS_CORETYPE that makes OpenBLAS use kernels for this processor's instruction set. Null if it
// uses such kernels already.
const char* cholmod_blas_wanted() {
  if (!openblas_get_corename) return nullptr;
  const std::string_view core = openblas_get_corename();
  const InstructionSet isa = instruction_set_in_use();
  const auto is_one_of = [&](std::initializer_list<std::string_view> names) {
    return std::find(names.begin(), names.end(), core) != names.end();
  };
  const bool wide = is_one_of({"SkylakeX", "Cooperlake", "SapphireRapids"});
  if (isa == InstructionSet::avx512) return wide ? nullptr : "SKYLAKEX";
  if (isa == InstructionSet::avx2) return wide || is_one_of({"Haswell", "Zen"}) ? nullptr : "HASWELL";
  return nullptr;
}

}  // namespace

void match_blas_to_processor() {
  const char* wanted = cholmod_blas_wanted();
  if (!wanted || std::getenv("OPENBLAS_CORETYPE")) return;
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  if (words.empty() || setenv("OPENBLAS_CORETYPE", wanted, 1) != 0) return;
  execv("/proc/self/exe",
        arguments.data());  // returns only on failure: then the run continues with the old kernels
}

BaselineNewton::BaselineNewton(std::shared_ptr<const Discretisation> discretisation, Baseline which)
    : d_(std::move(discretisation)) {
  const auto n = static_cast<int>(d_->free_nodes);
  // Upper rows in blocks are lower columns: column 3 i + a holds the rows 3 j + b >= 3 i + a.
  pattern_.n = 3 * n;
  pattern_.start.push_back(0);
  for (int i = 0; i < n; ++i)
    for (int a = 0; a < 3; ++a) {
      const auto row = static_cast<std::size_t>(i);
      std::int64_t s = d_->pattern.row_start[row];
      for (const std::uint32_t column : d_->pattern.row(row)) {
        const auto j = static_cast<int>(column);
        for (int b = i == j ? a : 0; b < 3 && j < n; ++b) {
          pattern_.row.push_back(3 * j + b);
          source_.push_back(9 * s + 3 * a + b);
        }
        ++s;
      }
      pattern_.start.push_back(static_cast<int>(pattern_.row.size()));
    }
  values_.resize(source_.size());
  blocks_.resize(9 * static_cast<std::size_t>(d_->pattern.size() + 1));
  gradient_.resize(static_cast<std::size_t>(d_->local_size()));
  right_.resize(gradient_.size());
  step_.resize(gradient_.size());
  solver_ = which == Baseline::cholmod ? make_cholmod(pattern_) : make_eigen_ldlt(pattern_);
}

bool BaselineNewton::factorise(const std::vector<double>& u) {
  std::fill(blocks_.begin(), blocks_.end(), 0.0);
  d_->elements.hessian(u.data(), blocks_.data());
  for (std::size_t i = 0; i < source_.size(); ++i) values_[i] = blocks_[static_cast<std::size_t>(source_[i])];
  return solver_->factor(values_.data());
}

State BaselineNewton::solve(std::vector<double>& u, const Vec3& x, double tolerance, int max_iterations) {
  const auto n = static_cast<std::size_t>(3 * d_->free_nodes);
  const auto border = [&](std::size_t row,
                          std::size_t c) -> double {  // of H_fc; 0 in rows that do not touch the contact
    const std::size_t i = row / 3;
    const auto last = static_cast<std::size_t>(d_->pattern.row_start[i + 1] - 1);
    return static_cast<std::int64_t>(d_->pattern.column[last]) == d_->free_nodes
               ? blocks_[9 * last + 3 * (row % 3) + c]
               : 0.0;
  };
  State s;
  s.at = x;
  s.solve.status = SolveStatus::stalled;
  Vec3 move = x - Vec3(u[n], u[n + 1], u[n + 2]);
  for (s.solve.iterations = 0; s.solve.iterations <= max_iterations; ++s.solve.iterations) {
    std::fill(gradient_.begin(), gradient_.end(), 0.0);
    const FieldSummary field = d_->elements.gradient(u.data(), gradient_.data());
    double squares = 0;
    for (std::size_t i = 0; i < n; ++i) squares += gradient_[i] * gradient_[i];
    s.force = -Vec3(gradient_[n], gradient_[n + 1], gradient_[n + 2]);
    s.solve.residual = std::sqrt(squares) / std::max(s.force.norm(), d_->force_floor);
    s.energy = field.energy;
    s.solve.min_jacobian = field.min_jacobian;
    if (!std::isfinite(s.solve.residual) || !std::isfinite(s.energy)) {
      s.solve.status = SolveStatus::diverged;
      return s;
    }
    if (move.isZero(0) && s.solve.residual <= tolerance) {
      s.solve.status = SolveStatus::converged;
      break;
    }
    if (!factorise(u)) {
      s.solve.status = SolveStatus::diverged;
      return s;
    }
    for (std::size_t i = 0; i < n; ++i)
      right_[i] = -gradient_[i] - border(i, 0) * move[0] - border(i, 1) * move[1] - border(i, 2) * move[2];
    solver_->solve(right_.data(), step_.data());
    for (std::size_t i = 0; i < n; ++i) u[i] += step_[i];
    for (std::size_t c = 0; c < 3; ++c) u[n + c] = x[static_cast<int>(c)];
    move.setZero();
  }
  if (s.solve.iterations == 0 && !factorise(u)) {  // already in equilibrium: there is no factor yet
    s.solve.status = SolveStatus::diverged;
    return s;
  }
  // Stiffness from the last factor.
  const double* corner = &blocks_[9 * static_cast<std::size_t>(d_->pattern.size() - 1)];
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < n; ++i) right_[i] = border(i, c);
    solver_->solve(right_.data(), step_.data());
    for (std::size_t a = 0; a < 3; ++a) {
      double sum = corner[3 * a + c];
      for (std::size_t i = 0; i < n; ++i) sum -= border(i, a) * step_[i];
      s.stiffness(static_cast<int>(a), static_cast<int>(c)) = sum;
    }
  }
  return s;
}

}  // namespace forefeel
