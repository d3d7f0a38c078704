#include "approx/error/error_scale.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "geometry/common/quantiles.hpp"

namespace forefeel {

ErrorScale::ErrorScale(std::span<const State> nearest, double spacing)
    : count_(std::min(nearest.size(), most)), spacing_(spacing) {
  for (std::size_t i = 0; i < count_; ++i) {
    tangents_[i].at = nearest[i].at;
    tangents_[i].force = nearest[i].force;
    if (nearest[i].has_stiffness()) tangents_[i].stiffness = nearest[i].stiffness;
  }
  measure_curvature();
}

void ErrorScale::measure_curvature() {
  if (count_ == 1) curvature_ = 0.1 * tangents_[0].stiffness.norm() / spacing_;
  if (count_ < 2) return;
  std::vector<double> departures;
  for (std::size_t i = 0; i < count_; ++i) {
    std::size_t nearest = i;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < count_; ++j) {
      const double d = (tangents_[j].at - tangents_[i].at).squaredNorm();
      if (j != i && d < least) {
        least = d;
        nearest = j;
      }
    }
    const Tangent &here = tangents_[i], &there = tangents_[nearest];
    const Vec3 departure = there.force - here.force + here.stiffness * (there.at - here.at);
    if (least > 0) departures.push_back(departure.norm() / least);
  }
  if (!departures.empty()) curvature_ = median(std::move(departures));
}

double ErrorScale::at(const Vec3& x, const Vec3& force) const noexcept {
  if (count_ == 0) return std::numeric_limits<double>::infinity();
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count_; ++i) {
    const double d = (x - tangents_[i].at).squaredNorm();
    if (d < least) {
      least = d;
      nearest = i;
    }
  }
  const Tangent& tangent = tangents_[nearest];
  const Vec3 expected = tangent.force - tangent.stiffness * (x - tangent.at);
  return stretch_ * ((force - expected).norm() + curvature_ * (0.5 * least + 0.01 * spacing_ * spacing_) +
                     1e-6 + 1e-6 * force.norm());
}

}  // namespace forefeel
