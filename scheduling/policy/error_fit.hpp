#pragma once
// A line fitted by least squares to the logarithms of errors, from a prior worth some states:
//   ln m = a + b ln(delta / h) + c side,   deviation v of the logarithm    (error_need.hpp)

#include <Eigen/Core>

namespace forefeel {

class ErrorFit {
 public:
  ErrorFit();  // the prior

  // The logarithm of an error. Returns how far it was from the line before [1].
  double learn(double delta_over_h, double side, double log_error);

  double intercept(double side) const { return fit_[0] + fit_[2] * side; }  // ln m at delta = h
  double slope() const { return fit_[1]; }                                  // b
  double median(double delta_over_h, double side) const;                    // m
  double deviation() const;                                                 // v

 private:
  Eigen::Matrix3d normal_;  // of the least squares
  Eigen::Vector3d right_, fit_;
  double squares_, count_;  // of residuals, with the prior's
};

// ln(delta / h), held constant near a state.
double log_distance(double delta_over_h);

}  // namespace forefeel
