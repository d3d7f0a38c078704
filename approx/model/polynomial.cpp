#include "approx/model/polynomial.hpp"

#include <Eigen/Dense>

namespace forefeel::detail {
namespace {

// Corners of a tetrahedron of circumradius 1.3, turned by an irrational angle about each axis, so that no
// anchor coincides with a lattice point or lies symmetrically among them.
struct Tetrahedron {
  Eigen::Matrix<double, 3, 4> corners;
  Eigen::Matrix4d barycentric;  // of (1, y)
  std::array<std::array<int, 2>, 6> edges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

  Tetrahedron() {
    Eigen::Matrix<double, 3, 4> regular;
    regular << 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1, 1;
    const double angle[3] = {0.3819660112501051, 0.7320508075688772, 0.4142135623730950};
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    for (int d = 0; d < 3; ++d) {
      Eigen::Matrix3d about = Eigen::Matrix3d::Identity();
      const int i = (d + 1) % 3, j = (d + 2) % 3;
      about(i, i) = about(j, j) = std::cos(angle[d]);
      about(i, j) = -std::sin(angle[d]);
      about(j, i) = std::sin(angle[d]);
      turn = about * turn;
    }
    corners = 1.3 / std::sqrt(3.0) * turn * regular;
    Eigen::Matrix4d homogeneous;
    homogeneous.row(0).setOnes();
    homogeneous.bottomRows<3>() = corners;
    barycentric = homogeneous.inverse();
  }
};

const Tetrahedron tetrahedron;

}  // namespace

std::array<double, 3> anchor(std::size_t j) {
  const auto node = static_cast<Eigen::Index>(j);
  if (j < 4)
    return {tetrahedron.corners(0, node), tetrahedron.corners(1, node), tetrahedron.corners(2, node)};
  const auto [a, b] = tetrahedron.edges[j - 4];
  const Eigen::Vector3d middle = 0.5 * (tetrahedron.corners.col(a) + tetrahedron.corners.col(b));
  return {middle[0], middle[1], middle[2]};
}

void lagrange(int degree, const double y[3], double* l, double* gradient) {
  if (degree == 0) {
    l[0] = 1;
    gradient[0] = gradient[1] = gradient[2] = 0;
    return;
  }
  const auto& b = tetrahedron.barycentric;
  double t[4];
  for (int j = 0; j < 4; ++j) t[j] = b(j, 0) + b(j, 1) * y[0] + b(j, 2) * y[1] + b(j, 3) * y[2];
  if (degree == 1) {
    for (int j = 0; j < 4; ++j) {
      l[j] = t[j];
      for (int d = 0; d < 3; ++d) gradient[3 * j + d] = b(j, d + 1);
    }
    return;
  }
  for (int j = 0; j < 4; ++j) {
    l[j] = t[j] * (2 * t[j] - 1);
    for (int d = 0; d < 3; ++d) gradient[3 * j + d] = (4 * t[j] - 1) * b(j, d + 1);
  }
  for (unsigned e = 0; e < 6; ++e) {
    const auto [i, k] = tetrahedron.edges[e];
    l[4 + e] = 4 * t[i] * t[k];
    for (unsigned d = 0; d < 3; ++d)
      gradient[3 * (4 + e) + d] = 4 * (b(i, d + 1) * t[k] + t[i] * b(k, d + 1));
  }
}

void to_monomials(int degree, const double* values, double* monomials) {
  std::fill_n(monomials, max_terms, 0.0);
  if (degree == 0) {
    monomials[0] = values[0];
    return;
  }
  const auto& b = tetrahedron.barycentric;
  // products of two affine functions, scaled
  const auto add_product = [&](int i, int k, double scale) {
    const Eigen::Vector4d u = b.row(i), w = b.row(k);
    monomials[0] += scale * u[0] * w[0];
    for (int d = 0; d < 3; ++d) {
      monomials[1 + d] += scale * (u[0] * w[d + 1] + u[d + 1] * w[0]);
      monomials[4 + d] += scale * u[d + 1] * w[d + 1];
    }
    monomials[7] += scale * (u[1] * w[2] + u[2] * w[1]);
    monomials[8] += scale * (u[1] * w[3] + u[3] * w[1]);
    monomials[9] += scale * (u[2] * w[3] + u[3] * w[2]);
  };
  for (int j = 0; j < 4; ++j) {
    const double linear = degree == 1 ? values[j] : -values[j];
    for (int d = 0; d < 4; ++d) monomials[d] += linear * b(j, d);
    if (degree == 2) add_product(j, j, 2 * values[j]);
  }
  if (degree == 2)
    for (unsigned e = 0; e < 6; ++e)
      add_product(tetrahedron.edges[e][0], tetrahedron.edges[e][1], 4 * values[4 + e]);
}

}  // namespace forefeel::detail
