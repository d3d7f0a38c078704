// x(t + s) = x + v s, with the velocity v smoothed over 30 ms.

#include <algorithm>
#include <cmath>
#include <deque>

#include "scheduling/motion/predictor.hpp"
#include "scheduling/motion/predictors.hpp"

namespace forefeel {
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

}  // namespace forefeel
