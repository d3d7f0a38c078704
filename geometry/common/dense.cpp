#include "geometry/common/dense.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace forefeel {

using Eigen::MatrixXd;

MatrixXd solved(const MatrixXd& a, const MatrixXd& b) {
  return a.partialPivLu().solve(b);
}

MatrixXd least_squares(const MatrixXd& a, const MatrixXd& b) {
  return a.colPivHouseholderQr().solve(b);
}

MatrixXd smallest_least_squares(const MatrixXd& a, const MatrixXd& b, std::optional<double> threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> factor;
  if (threshold) factor.setThreshold(*threshold);
  factor.compute(a);
  return factor.solve(b);
}

MatrixXd pseudo_inverse(const MatrixXd& a) {
  return a.completeOrthogonalDecomposition().pseudoInverse();
}

Orthogonal orthogonal_of(const MatrixXd& a) {
  const Eigen::HouseholderQR<MatrixXd> qr(a);
  return {.q = qr.householderQ(), .upper = qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>()};
}

RankedOrthogonal ranked_orthogonal_of(const MatrixXd& a, double threshold) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(a);
  qr.setThreshold(threshold);
  return {.rank = qr.rank(), .q = qr.householderQ()};
}

Eigen::Index rank_of(const MatrixXd& a, std::optional<double> threshold) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(a);
  if (threshold) qr.setThreshold(*threshold);
  return qr.rank();
}

std::optional<MatrixXd> cholesky_of(const MatrixXd& a) {
  const Eigen::LLT<MatrixXd> factor(a);
  if (factor.info() != Eigen::Success) return {};
  return factor.matrixLLT();
}

void solve_lower(const MatrixXd& l, MatrixXd& b) {
  l.triangularView<Eigen::Lower>().solveInPlace(b);
}

void solve_lower_transposed(const MatrixXd& l, MatrixXd& b) {
  l.triangularView<Eigen::Lower>().adjoint().solveInPlace(b);
}

Modes modes_of(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(a);
  return {.values = solver.eigenvalues(), .vectors = solver.eigenvectors()};
}

Modes3 axes_of(const Mat3& a) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(a);
  return {.values = solver.eigenvalues(), .vectors = solver.eigenvectors()};
}

Mat3 square_root_of(const Mat3& a) {
  return Eigen::SelfAdjointEigenSolver<Mat3>(a).operatorSqrt();
}

double spectral_radius_of(MatrixXd a) {
  double logarithm = 0, share = 1;
  for (int k = 0; k < 40; ++k, share /= 2) {
    const double norm = a.norm();
    if (!(norm > 0)) return 0;
    logarithm += share * std::log(norm);
    a = (a / norm) * (a / norm);
  }
  return std::exp(logarithm);
}

Mat3 turn_between(const Vec3& from, const Vec3& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

}  // namespace forefeel
