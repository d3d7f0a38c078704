// Eigen's SimplicialLDLT, compiled once per instruction set. The macro gives each copy its own names, so that
// the linker cannot mix them.
#define FOREFEEL_PASTED(a, b) a##b
#define FOREFEEL_EIGEN(isa) FOREFEEL_PASTED(EigenLdlt_, isa)
#define Eigen FOREFEEL_EIGEN(FOREFEEL_ISA)
#include <Eigen/SparseCholesky>

namespace forefeel {
namespace FOREFEEL_ISA {

class EigenLdlt {
 public:
  EigenLdlt(int n, const int* start, const int* row) : matrix_(n, n) {
    matrix_.resizeNonZeros(start[n]);
    for (int i = 0; i <= n; ++i) matrix_.outerIndexPtr()[i] = start[i];
    for (int i = 0; i < start[n]; ++i) matrix_.innerIndexPtr()[i] = row[i];
    for (int i = 0; i < start[n]; ++i) matrix_.valuePtr()[i] = 0;
    ldlt_.analyzePattern(matrix_);
  }
  bool factor(const double* values) {
    for (int i = 0; i < matrix_.nonZeros(); ++i) matrix_.valuePtr()[i] = values[i];
    ldlt_.factorize(matrix_);
    return ldlt_.info() == Eigen::Success;
  }
  void solve(const double* b, double* x) {
    Eigen::Map<Eigen::VectorXd>(x, matrix_.rows()) =
        ldlt_.solve(Eigen::Map<const Eigen::VectorXd>(b, matrix_.rows()));
  }

 private:
  Eigen::SparseMatrix<double> matrix_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt_;
};

void* make_ldlt(int n, const int* start, const int* row) {
  return new EigenLdlt(n, start, row);
}
void free_ldlt(void* ldlt) {
  delete static_cast<EigenLdlt*>(ldlt);
}
bool factor_ldlt(void* ldlt, const double* values) {
  return static_cast<EigenLdlt*>(ldlt)->factor(values);
}
void solve_ldlt(void* ldlt, const double* b, double* x) {
  static_cast<EigenLdlt*>(ldlt)->solve(b, x);
}

}  // namespace FOREFEEL_ISA
}  // namespace forefeel
