#include "solver/factorisation.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace forefeel {

struct Factorisation::Impl {
  const Discretisation& d;
  Eigen::SparseMatrix<double> lower;
  std::vector<std::int64_t> source;          // of each stored value, in the block values; -1: by position below
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>> factor;
  Eigen::MatrixXd border;                    // H_fc
  Eigen::MatrixXd tangent;
  Mat3 corner = Mat3::Zero(), stiffness = Mat3::Zero();

  explicit Impl(const Discretisation& discretisation) : d(discretisation) {
    fill(nullptr);
    factor.analyzePattern(lower);
  }

  void fill(const double* blocks) {
    const auto n = static_cast<int>(d.free_nodes);
    std::vector<Eigen::Triplet<double>> entries;
    border = Eigen::MatrixXd::Zero(3 * n, 3);
    for (int i = 0; i <= n; ++i)
      for (std::int64_t s = d.pattern.row_start[static_cast<std::size_t>(i)];
           s < d.pattern.row_start[static_cast<std::size_t>(i) + 1]; ++s) {
        const int j = d.pattern.column[static_cast<std::size_t>(s)];
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            const double value = blocks == nullptr ? 0.0 : blocks[9 * s + 3 * a + b];
            if (i == n)
              corner(a, b) = value;
            else if (j == n)
              border(3 * i + a, b) = value;
            else if (i != j || b >= a)
              entries.emplace_back(3 * j + b, 3 * i + a, value);
          }
      }
    lower.resize(3 * n, 3 * n);
    lower.setFromTriplets(entries.begin(), entries.end());
  }
};

Factorisation::Factorisation(const Discretisation& discretisation) : impl_(std::make_unique<Impl>(discretisation)) {}
Factorisation::~Factorisation() = default;
Factorisation::Factorisation(Factorisation&&) noexcept = default;

bool Factorisation::compute(const double* blocks) {
  Impl& f = *impl_;
  f.fill(blocks);
  f.factor.factorize(f.lower);
  if (f.factor.info() != Eigen::Success) return false;
  f.tangent = -f.factor.solve(f.border);
  const Mat3 k = f.corner + f.border.transpose() * f.tangent;
  f.stiffness = 0.5 * (k + k.transpose());
  return f.tangent.allFinite();
}

void Factorisation::solve(double* b) const {
  Eigen::Map<Eigen::VectorXd> rhs(b, 3 * impl_->d.free_nodes);
  rhs = impl_->factor.solve(rhs).eval();
}

Mat3 Factorisation::stiffness() const { return impl_->stiffness; }

void Factorisation::tangent(double* v) const {
  const std::int64_t n = 3 * impl_->d.free_nodes;
  std::fill(v, v + 3 * (n + 6), 0.0);
  for (std::int64_t i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c) v[3 * i + c] = impl_->tangent(i, c);
  for (int c = 0; c < 3; ++c) v[3 * (n + c) + c] = 1;
}

}  // namespace forefeel
