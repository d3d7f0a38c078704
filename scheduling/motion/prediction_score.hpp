#pragma once
// The error of a predictor as a function of the horizon.

#include <array>
#include <cstddef>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scheduling/motion/hip_sample.hpp"
#include "scheduling/motion/predictor.hpp"

namespace forefeel {

// Error at one horizon, over a motion sampled every `step` seconds.
struct PredictionError {
  double horizon = 0;           // [s]
  double p50 = 0, p95 = 0;      // quantiles of |predicted - true| [m]
  double within_deviation = 0;  // share of true positions within 2 deviations, per axis
  // Calibration: shares of true positions within the balls that hold 50 and 90 % of the predicted normal distribution.
  double within_50 = 0, within_90 = 0;
};
inline constexpr std::array score_horizons{0.02, 0.05, 0.1, 0.2, 0.5};  // [s]

// Accumulates the errors over a motion, one position at a time.
class PredictionScore {
 public:
  // horizons [s]. The predictor must outlive this. It observes every position and predicts at each stride-th.
  PredictionScore(Predictor& predictor, double step, std::span<const double> horizons = score_horizons,
                  std::size_t stride = 1);
  void add(const Vec3& at);                     // the next position [m]
  std::vector<PredictionError> report() const;  // #horizons

 private:
  struct Ahead {
    double horizon;
    std::size_t steps;
    std::deque<Prediction> made;  // not yet compared with a position
    std::vector<double> errors;
    std::size_t within = 0, within_50 = 0, within_90 = 0;
  };
  Predictor& predictor_;
  double step_;
  Vec3 before_ = Vec3::Zero();
  std::size_t stride_, seen_ = 0;
  std::vector<Ahead> ahead_;
};

// The errors of one predictor by horizon.
struct PredictorErrors {
  std::string predictor;
  std::vector<PredictionError> by_horizon;
};
// The error that each built-in predictor and the session's own would have made on one motion, at score_horizons;
// `network` only with the file of the session's own.
class PredictorScores {
 public:
  // step: of the motion [s]; own: the session's predictor, as it is made in its context.
  explicit PredictorScores(double step, const PredictorSpec& own = {}, const FactoryContext& context = {});
  ~PredictorScores();
  void add(const Vec3& at);                     // the next position [m]
  std::vector<PredictorErrors> report() const;  // sorted by name

 private:
  std::vector<std::string> names_;
  std::vector<std::unique_ptr<Predictor>> predictors_;
  std::vector<PredictionScore> scores_;
};

}  // namespace forefeel
