// Compiled once per instruction set; Eigen's namespace is renamed so that the linker cannot mix them.
#define FOREFEEL_PASTED(a, b) a##b
#define FOREFEEL_EIGEN(isa) FOREFEEL_PASTED(EigenLu_, isa)
#define Eigen FOREFEEL_EIGEN(FOREFEEL_ISA)
#include <Eigen/LU>

namespace forefeel::FOREFEEL_ISA {
namespace {

struct Work {
  bool hermite;
  Eigen::MatrixXd matrix, right, solution;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu;
  Work(Eigen::Index size, bool with_stiffness)
      : hermite(with_stiffness), matrix(size, size), right(size, 3), solution(size, 3), lu(size) {}
};

void assemble_cubic(Work& w, Eigen::Index n, const double* p) {
  using Array = Eigen::Map<const Eigen::ArrayXd>;
  const Array x(p, n), y(p + n, n), z(p + 2 * n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    auto column = w.matrix.col(j).head(n).array();
    column = (x - x[j]).square() + (y - y[j]).square() + (z - z[j]).square();
    column *= column.sqrt();
  }
  w.matrix.col(n).head(n).setOnes();
  w.matrix.col(n + 1).head(n) = x.matrix();
  w.matrix.col(n + 2).head(n) = y.matrix();
  w.matrix.col(n + 3).head(n) = z.matrix();
  w.matrix.bottomLeftCorner(4, n) = w.matrix.topRightCorner(n, 4).transpose();
  w.matrix.bottomRightCorner(4, 4).setZero();
}

void assemble_hermite_quintic(Work& w, Eigen::Index n, const double* p) {
  const double *x = p, *y = p + n, *z = p + 2 * n;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i) {
      const double d[3] = {x[i] - x[j], y[i] - y[j], z[i] - z[j]};
      const double r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], r = std::sqrt(r2), first = 5 * r * r2,
                   second = 15 * r;
      double* to = &w.matrix(4 * i, 4 * j);
      const Eigen::Index stride = w.matrix.rows();
      to[0] = r * r2 * r2;
      for (int a = 0; a < 3; ++a) {
        to[a + 1] = first * d[a];
        to[(a + 1) * stride] = -first * d[a];
        for (int b = 0; b < 3; ++b)
          to[a + 1 + (b + 1) * stride] = -second * d[a] * d[b] - (a == b ? first : 0);
      }
    }
  auto terms = w.matrix.topRightCorner(4 * n, 10);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double a = x[i], b = y[i], c = z[i];
    terms.row(4 * i) << 1, a, b, c, a * a, b * b, c * c, a * b, a * c, b * c;
    terms.row(4 * i + 1) << 0, 1, 0, 0, 2 * a, 0, 0, b, c, 0;
    terms.row(4 * i + 2) << 0, 0, 1, 0, 0, 2 * b, 0, a, 0, c;
    terms.row(4 * i + 3) << 0, 0, 0, 1, 0, 0, 2 * c, 0, a, b;
  }
  w.matrix.bottomLeftCorner(10, 4 * n) = terms.transpose();
  w.matrix.bottomRightCorner(10, 10).setZero();
}

}  // namespace

void* make_lu(long n, bool hermite) {
  return new Work(hermite ? 4 * n + 10 : n + 4, hermite);
}
void free_lu(void* work) {
  delete static_cast<Work*>(work);
}
double refit_lu(void* work, long n, const double* positions, const double* values) {
  Work& w = *static_cast<Work*>(work);
  const Eigen::Index rows = w.hermite ? 4 * n : n;
  if (w.hermite)
    assemble_hermite_quintic(w, n, positions);
  else
    assemble_cubic(w, n, positions);
  w.right.setZero();
  w.right.topRows(rows) = Eigen::Map<const Eigen::MatrixXd>(values, rows, 3);
  w.lu.compute(w.matrix);
  w.solution = w.lu.solve(w.right);
  return w.solution(0, 0);
}

}  // namespace forefeel::FOREFEEL_ISA
