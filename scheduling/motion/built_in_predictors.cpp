#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <deque>

#include "scheduling/motion/predictor.hpp"
#include "scheduling/motion/predictors.hpp"

namespace forefeel {

// x(t + s) = x + v s, with the velocity v smoothed over 30 ms.

namespace {

constexpr double memory = 0.03;  // [s] over which the velocity is smoothed

// The deviation is measured. Predictions over a probing horizon of 0.1 s are kept and later compared with the
// true position. Their mean square error gives the acceleration that the model of constant velocity neglects.
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
  static constexpr double probe = 0.1;  // [s]
  bool seen_ = false;
  HipSample last_;
  Vec3 velocity_ = Vec3::Zero();
  std::deque<HipSample> made_;  // predictions, by target time
  double error2_ = 1e-6;        // mean square per axis over the probing horizon [m^2]
};

}  // namespace

std::unique_ptr<Predictor> make_constant_velocity(FactoryContext&) {
  return std::make_unique<ConstantVelocity>();
}

// State (x, v, a) of each axis, with an acceleration that decays over tau (Singer 1970):
//   dx = v,  dv = a - v / tau_v,  da = -a / tau + white noise
// The model has constant acceleration over short horizons and stays bounded over long ones. The filter itself
// uses tau_v = infinity. Predictions use a finite tau_v, because hands turn: it is learnt from the motion and
// stays infinite while the motion is straight. The standard deviation is that of the filter, scaled by the
// errors measured so far.

namespace {

// One filter serves the three axes: covariance and gain do not depend on the data, so the axes share them.
// tau_v follows from the fraction of the predicted distance that the hand covered within 0.4 s. The deviation
// is that of the filter times the ratio of measured to expected error over 0.1 s.
class Kalman final : public Predictor {
 public:
  void observe(const HipSample& sample) override {
    if (!seen_) {
      mean_.setZero();
      mean_.row(0) = sample.at.transpose();
      covariance_ = Eigen::Vector3d(noise * noise, 0.01, 0.25).asDiagonal();
    } else if (sample.t > t_) {
      const double dt = sample.t - t_;
      if (dt != step_) {  // frames are evenly spaced: computed once
        step_ = dt;
        transition_ = transition(dt, forever);
        process_ = process(dt, forever);
      }
      mean_ = transition_ * mean_;
      covariance_ = transition_ * covariance_ * transition_.transpose() + process_;
      const Eigen::Vector3d gain = covariance_.col(0) / (covariance_(0, 0) + noise * noise);
      mean_ += gain * (sample.at.transpose() - mean_.row(0));
      covariance_ -= gain * covariance_.row(0).eval();
      covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
      compare(sample, dt);
      persist(sample, dt);
    }
    t_ = sample.t;
    seen_ = true;
    const Prediction p = unscaled(probe);
    made_.push_back({.t = sample.t + probe, .at = p.at, .deviation = p.deviation});
    persistence_.gone.push_back(
        {.t = sample.t + long_probe, .at = sample.at, .velocity = mean_.row(1).transpose()});
  }

  Prediction predict(double horizon) const override {
    Prediction p = unscaled(horizon);
    p.deviation *= std::sqrt(ratio2_);
    return p;
  }

 private:
  static constexpr double noise = 5e-4;   // of a position [m]; large because tremor is not white
  static constexpr double tau = 0.1;      // of the acceleration [s]; voluntary motion is below 2 Hz
  static constexpr double spread = 0.25;  // standard deviation of the acceleration [m/s^2]
  static constexpr double probe = 0.1, long_probe = 0.4;  // [s]
  static constexpr double forever = 1e6;                  // [s]
  struct Made {
    double t;
    Vec3 at;
    double deviation;
  };

  // Of the velocity; see persist().
  struct Persistence {
    std::deque<HipSample> gone;  // position and velocity 0.4 s ago; t: when to measure the distance
    double along = 0, length2 = 0, tau_v = forever;
  };

  // Compares this sample with the predictions made for its time or earlier.
  void compare(const HipSample& sample, double dt) {
    for (; !made_.empty() && made_.front().t <= sample.t; made_.pop_front()) {
      const double error2 = (made_.front().at - sample.at).squaredNorm() / 3;
      const double seen2 = std::min(error2 / (made_.front().deviation * made_.front().deviation), 1e6);
      ratio2_ = std::max(ratio2_ + (1 - std::exp(-dt / 0.5)) * (seen2 - ratio2_), 0.1);
    }
  }
  // beta = distance covered along v / (|v| T) over T = 0.4 s, averaged over the last seconds. tau_v solves
  //   tau_v (1 - exp(-T / tau_v)) = beta T
  void persist(const HipSample& sample, double dt) {
    Persistence& p = persistence_;
    constexpr double long_memory = 2;  // [s]
    for (; !p.gone.empty() && p.gone.front().t <= sample.t; p.gone.pop_front()) {
      const Vec3 foretold = long_probe * p.gone.front().velocity;
      const double keep = std::exp(-dt / long_memory);
      p.along = keep * p.along + (1 - keep) * foretold.dot(sample.at - p.gone.front().at);
      p.length2 = keep * p.length2 + (1 - keep) * foretold.squaredNorm();
    }
    const double beta = std::clamp(p.length2 > 0 ? p.along / p.length2 : 1.0, 0.05, 1.0);
    if (beta > 1 - 1e-4) {
      p.tau_v = forever;
      return;
    }
    double u = beta < 0.5 ? 1 / beta : 4 * (1 - beta);  // T / tau_v: Newton's method from above, monotone
    for (int i = 0; i < 8; ++i) {
      const double e = std::exp(-u), next = u - (1 - e - beta * u) / (e - beta);
      if (next == u) break;  // converged
      u = next;
    }
    p.tau_v = long_probe / u;
  }
  Prediction unscaled(double horizon) const {
    const Mat3 f = transition(horizon, persistence_.tau_v);
    const Mat3 p = f * covariance_ * f.transpose() + process(horizon, persistence_.tau_v);
    return {.horizon = horizon,
            .at = (f.row(0) * mean_).transpose(),
            .deviation = std::sqrt(std::max(p(0, 0), 0.0))};
  }

  // F(s) of dx = v, dv = a - v / tau_v, da = -a / tau.
  static Mat3 transition(double s, double tau_v) {
    const double fast = std::exp(-s / tau), slow = std::exp(-s / tau_v),
                 way = -tau_v * std::expm1(-s / tau_v);
    const double both = 1 / (1 / tau_v - 1 / tau);
    Mat3 f;
    f << 1, way, both * (tau * (1 - fast) - way), 0, slow, both * (fast - slow), 0, 0, fast;
    return f;
  }
  // Covariance of the driven state, by 4-point Gauss-Legendre quadrature of F(s) q F(s)^T over the step.
  static Mat3 process(double s, double tau_v) {
    constexpr double place[4] = {0.0694318442, 0.3300094782, 0.6699905218, 0.9305681558};
    constexpr double weight[4] = {0.1739274226, 0.3260725774, 0.3260725774, 0.1739274226};
    const double q = 2 * spread * spread / tau;
    Mat3 sum = Mat3::Zero();
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d column = transition(place[i] * s, tau_v).col(2);
      sum += weight[i] * s * q * column * column.transpose();
    }
    return sum;
  }

  bool seen_ = false;
  double t_ = 0, step_ = 0;
  Mat3 mean_ = Mat3::Zero();  // rows x, v, a; a column per axis
  Mat3 covariance_ = Mat3::Zero(), transition_ = Mat3::Identity(), process_ = Mat3::Zero();
  std::deque<Made> made_;  // predictions, by target time
  double ratio2_ = 1;      // mean of (measured error / expected error)^2
  Persistence persistence_;
};

}  // namespace

std::unique_ptr<Predictor> make_kalman(FactoryContext&) {
  return std::make_unique<Kalman>();
}

}  // namespace forefeel
