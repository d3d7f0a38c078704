#include "scheduling/predictor.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <deque>

#include "geometry/error.hpp"

namespace forefeel {
namespace {

constexpr double memory = 0.03;   // [s] over which the velocity is smoothed

// Its deviation is measured: predictions over a probing horizon are kept until they can be compared, and their mean
// square error gives the acceleration that a constant velocity misses.
class ConstantVelocity final : public Predictor {
 public:
  void observe(const HipSample& sample) override {
    const double dt = sample.t - last_.t;
    if (seen_ && dt > 0) {
      velocity_ += (1 - std::exp(-dt / memory)) * ((sample.at - last_.at) / dt - velocity_);
      while (!made_.empty() && made_.front().t <= sample.t) {
        const double error2 = (made_.front().at - sample.at).squaredNorm() / 3;
        made_.pop_front();
        error2_ += (1 - std::exp(-dt / 0.5)) * (error2 - error2_);
      }
    }
    last_ = sample;
    seen_ = true;
    made_.push_back({.t = sample.t + probe, .at = sample.at + probe * velocity_, .velocity = velocity_});
  }

  Prediction predict(double horizon) const override {
    const double share = horizon / probe;
    return {.horizon = horizon,
            .at = last_.at + horizon * velocity_,
            .deviation = std::hypot(0.0002, std::sqrt(error2_) * share * std::max(1.0, share))};
  }

 private:
  static constexpr double probe = 0.1;   // [s]
  bool seen_ = false;
  HipSample last_;
  Vec3 velocity_ = Vec3::Zero();
  std::deque<HipSample> made_;           // predictions, by the time they are for
  double error2_ = 1e-6;                 // mean square per axis over the probing horizon [m^2]
};

// One filter for the three axes: they share covariance and gain, which do not depend on the data.
class Kalman final : public Predictor {
 public:
  void observe(const HipSample& sample) override {
    if (!seen_) {
      mean_.setZero();
      mean_.row(0) = sample.at.transpose();
      covariance_ = Eigen::Vector3d(noise * noise, 0.01, 0.25).asDiagonal();
    } else if (sample.t > t_) {
      const double dt = sample.t - t_;
      if (dt != step_) {   // frames come evenly: the matrices are made once
        step_ = dt;
        transition_ = transition(dt);
        process_ = process(dt);
      }
      mean_ = transition_ * mean_;
      covariance_ = transition_ * covariance_ * transition_.transpose() + process_;
      const Eigen::Vector3d gain = covariance_.col(0) / (covariance_(0, 0) + noise * noise);
      mean_ += gain * (sample.at.transpose() - mean_.row(0));
      covariance_ -= gain * covariance_.row(0).eval();
      covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
    }
    t_ = sample.t;
    seen_ = true;
  }

  Prediction predict(double horizon) const override {
    const Mat3 f = transition(horizon);
    const Mat3 p = f * covariance_ * f.transpose() + process(horizon);
    return {.horizon = horizon, .at = (f.row(0) * mean_).transpose(), .deviation = std::sqrt(std::max(p(0, 0), 0.0))};
  }

 private:
  static constexpr double noise = 1e-4;    // of a position [m]: tremor
  static constexpr double tau = 0.15;      // of the acceleration [s]: voluntary motion is below 2 Hz
  static constexpr double spread = 0.5;    // standard deviation of the acceleration [m/s^2]

  static Mat3 transition(double s) {
    const double e = std::exp(-s / tau);
    Mat3 f;
    f << 1, s, tau * (s - tau * (1 - e)), 0, 1, tau * (1 - e), 0, 0, e;
    return f;
  }
  // Singer's covariance of the driven state, by 4-point Gauss-Legendre quadrature of F(s) q F(s)^T over the step.
  static Mat3 process(double s) {
    constexpr double place[4] = {0.0694318442, 0.3300094782, 0.6699905218, 0.9305681558};
    constexpr double weight[4] = {0.1739274226, 0.3260725774, 0.3260725774, 0.1739274226};
    const double q = 2 * spread * spread / tau;
    Mat3 sum = Mat3::Zero();
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d column = transition(place[i] * s).col(2);
      sum += weight[i] * s * q * column * column.transpose();
    }
    return sum;
  }

  bool seen_ = false;
  double t_ = 0, step_ = 0;
  Mat3 mean_ = Mat3::Zero();   // rows x, v, a; a column per axis
  Mat3 covariance_ = Mat3::Zero(), transition_ = Mat3::Identity(), process_ = Mat3::Zero();
};

}  // namespace

std::vector<std::string> predictor_names() { return {"constant-velocity", "kalman"}; }

std::unique_ptr<Predictor> make_predictor(const std::string& name) {
  if (name == "constant-velocity") return std::make_unique<ConstantVelocity>();
  if (name == "kalman") return std::make_unique<Kalman>();
  throw InputError("predictor", fmt::format("unknown predictor '{}', expected one of {}", name,
                                            fmt::join(predictor_names(), ", ")));
}

std::vector<PredictionError> prediction_error(Predictor& predictor, const std::vector<Vec3>& motion, double step,
                                              std::span<const double> horizons) {
  std::vector<std::vector<double>> errors(horizons.size());
  std::vector<std::size_t> within(horizons.size(), 0);
  for (std::size_t i = 0; i < motion.size(); ++i) {
    predictor.observe({.t = static_cast<double>(i) * step, .at = motion[i], .velocity = Vec3::Zero()});
    for (std::size_t k = 0; k < horizons.size(); ++k) {
      const auto later = i + static_cast<std::size_t>(std::llround(horizons[k] / step));
      if (later >= motion.size()) continue;
      const Prediction p = predictor.predict(horizons[k]);
      errors[k].push_back((p.at - motion[later]).norm());
      within[k] += ((p.at - motion[later]).cwiseAbs().array() <= 2 * p.deviation).all();
    }
  }
  std::vector<PredictionError> report;
  for (std::size_t k = 0; k < horizons.size(); ++k) {
    PredictionError e{.horizon = horizons[k]};
    if (!errors[k].empty()) {
      std::sort(errors[k].begin(), errors[k].end());
      e.p50 = errors[k][errors[k].size() / 2];
      e.p95 = errors[k][errors[k].size() * 95 / 100];
      e.within_deviation = static_cast<double>(within[k]) / static_cast<double>(errors[k].size());
    }
    report.push_back(e);
  }
  return report;
}

}  // namespace forefeel
