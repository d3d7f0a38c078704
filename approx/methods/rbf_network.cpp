#include "approx/methods/rbf_network.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

// Positions of the network are centred and of size 1; positions nearer than this count as equal. It is far
// above the rounding error of states a kilometre from the origin and far below any distance that matters.
constexpr double tie = 1e-8;

// Rank of every point by x, y and z. Coordinates that differ by rounding have the same rank: a rank ends at a
// gap in the sorted order, so that no rounding grid can separate two equal coordinates.
std::vector<std::array<std::size_t, 3>> ranks_of(const std::vector<Vec3>& points) {
  std::vector<std::array<std::size_t, 3>> ranks(points.size());
  std::vector<std::size_t> order(points.size());
  for (std::size_t d = 0; d < 3; ++d) {
    const auto along = [&](std::size_t i) { return points[i][Eigen::Index(d)]; };
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, along);
    std::size_t rank = 0;
    for (std::size_t k = 0; k < order.size(); ++k) {
      if (k > 0 && along(order[k]) - along(order[k - 1]) > tie) ++rank;
      ranks[order[k]][d] = rank;
    }
  }
  return ranks;
}

// Farthest-point sampling, from the point nearest to the origin on; the first of `points` among equals.
std::vector<Vec3> spread(const std::vector<Vec3>& points, std::size_t count) {
  std::vector<Vec3> chosen;
  std::vector<double> distance(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) distance[i] = points[i].norm();
  const double least = *std::ranges::min_element(distance);
  auto next = std::ranges::find_if(distance, [&](double r) { return r <= least + tie; });
  std::vector<double> far(points.size(), 1e300);
  for (auto i = std::size_t(next - distance.begin()); chosen.size() < count && far[i] > tie;) {
    chosen.push_back(points[i]);
    for (std::size_t j = 0; j < points.size(); ++j)
      far[j] = std::min(far[j], (points[j] - chosen.back()).norm());
    const double most = *std::ranges::max_element(far);
    i = std::size_t(std::ranges::find_if(far, [&](double r) { return r >= most - tie; }) - far.begin());
  }
  return chosen;
}

}  // namespace

std::size_t RbfNetwork::centres_of(std::size_t states, std::size_t wished) {
  return std::min(states, wished > 0 ? wished : std::max<std::size_t>(10, states / 5));
}

RbfNetwork::RbfNetwork(std::span<const State> states, std::size_t centres) {
  std::vector<const State*> known;
  for (const State& s : states)
    if (s.usable()) known.push_back(&s);
  const std::size_t n = known.size();
  centres = centres_of(n, centres);
  // Relative to the first state, so that the distance to the origin of coordinates does not matter.
  const Vec3 origin = known[0]->at;
  Vec3 mean = Vec3::Zero();
  for (const State* s : known) mean += (s->at - origin) / double(n);
  middle_ = origin + mean;
  scale_ = 0;
  for (const State* s : known) scale_ = std::max(scale_, (s->at - middle_).norm());
  if (!(scale_ > 0)) scale_ = 1;
  std::vector<Vec3> points;
  for (const State* s : known) points.emplace_back((s->at - middle_) / scale_);
  // Sorted by position, so that neither the centres nor the sums depend on the order of the states.
  const auto ranks = ranks_of(points);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return ranks[i]; });
  std::vector<Vec3> sorted;
  for (const std::size_t i : order) sorted.push_back(points[i]);
  centres_ = spread(sorted, centres);
  const auto m = static_cast<Eigen::Index>(centres_.size());
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(n), m + 4);
  Eigen::MatrixXd right(static_cast<Eigen::Index>(n), 3);
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Vec3& y = sorted[i];
    for (Eigen::Index j = 0; j < m; ++j) {
      const double r = (y - centres_[std::size_t(j)]).norm();
      matrix(row, j) = r * r * r;
    }
    matrix(row, m) = 1;
    matrix.block<1, 3>(row, m + 1) = y.transpose();
    right.row(row) = known[order[i]]->force.transpose();
  }
  // If the states do not determine the weights (as many centres as states, states in a plane), the smallest weights are
  // used, because they do not depend on the order in which columns are eliminated.
  weights_ = smallest_least_squares(matrix, right, 1e-10);
}

Vec3 RbfNetwork::force(const Vec3& x) const {
  const auto m = static_cast<Eigen::Index>(centres_.size());
  const Vec3 y = (x - middle_) / scale_;
  Vec3 sum = (weights_.row(m) + y.transpose() * weights_.bottomRows<3>()).transpose();
  for (Eigen::Index j = 0; j < m; ++j) {
    const double r = (y - centres_[std::size_t(j)]).norm();
    sum += r * r * r * weights_.row(j).transpose();
  }
  return sum;
}

}  // namespace forefeel
