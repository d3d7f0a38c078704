#pragma once
// Decompositions of dense matrices, compiled once: a file that names Eigen's own compiles ten seconds longer. Each is
// what Eigen computes with its default thresholds. A: any matrix of doubles, not empty.

#include <Eigen/Core>
#include <optional>

#include "geometry/common/types.hpp"

namespace forefeel {

// X of A X = B, A square and regular (LU, partial pivoting).
Eigen::MatrixXd solved(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
// X of least |A X - B| (QR, column pivoting).
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
// The same X with the least |X| if A does not determine it. threshold: pivots below it, relative to the largest, are 0;
// nullopt: Eigen's.
Eigen::MatrixXd smallest_least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                       std::optional<double> threshold = {});
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a);

// A = Q R (Householder).
struct Orthogonal {
  Eigen::MatrixXd q;      // rows x rows
  Eigen::MatrixXd upper;  // R, columns x columns; of more rows than columns
};
Orthogonal orthogonal_of(const Eigen::MatrixXd& a);
// With column pivoting: the rank of A, and Q, whose first columns span A's.
struct RankedOrthogonal {
  Eigen::Index rank = 0;
  Eigen::MatrixXd q;
};
RankedOrthogonal ranked_orthogonal_of(const Eigen::MatrixXd& a, double threshold);
// threshold: as before.
Eigen::Index rank_of(const Eigen::MatrixXd& a, std::optional<double> threshold = {});

// L of A = L L^T in the lower triangle; the rest is not defined. nullopt: A is not positive definite.
std::optional<Eigen::MatrixXd> cholesky_of(const Eigen::MatrixXd& a);
void solve_lower(const Eigen::MatrixXd& l, Eigen::MatrixXd& b);             // b := L^-1 b
void solve_lower_transposed(const Eigen::MatrixXd& l, Eigen::MatrixXd& b);  // b := L^-T b

// Of a symmetric A: eigenvalues, ascending, and eigenvectors in the columns.
struct Modes {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
Modes modes_of(const Eigen::MatrixXd& a);
struct Modes3 {
  Vec3 values;
  Mat3 vectors;
};
Modes3 axes_of(const Mat3& a);
Mat3 square_root_of(const Mat3& a);  // of a symmetric, positive definite A

// Largest modulus of an eigenvalue, to about 1e-9 of it: lim |A^n|^(1/n), by 40 squarings.
double spectral_radius_of(Eigen::MatrixXd a);
Mat3 turn_between(const Vec3& from,
                  const Vec3& to);  // the least rotation that takes one direction to the other

}  // namespace forefeel
