#pragma once
// The method rbf_network (older_methods.hpp): r^3 and linear p by least squares, with fewer centres than states.

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

class RbfNetwork {
 public:
  RbfNetwork(std::span<const State> states, std::size_t centres);
  Vec3 force(const Vec3& x) const;
  std::size_t centres() const { return centres_.size(); }
  static std::size_t centres_of(std::size_t states,
                                std::size_t wished);  // wished 0: a fifth of the states, at least 10

 private:
  Vec3 middle_ = Vec3::Zero();
  double scale_ = 1;
  std::vector<Vec3> centres_;                         // scaled
  Eigen::Matrix<double, Eigen::Dynamic, 3> weights_;  // (centres + 4) x 3
};

}  // namespace forefeel
