#pragma once
// Where the HIP will be. Per axis, after observing x at frame times:
//   constant-velocity   x(t + s) = x + v s, v smoothed over 30 ms
//   kalman              state (x, v, a) with a decaying over tau_a (Singer 1970): constant acceleration over short
//                       horizons, no runaway over long ones. Predictions let v decay too, dv = a - v / tau_v, as
//                       hands turn; tau_v is learnt from the motion, infinite as long as it is straight. The
//                       deviation is the filter's own, scaled by what it was seen to miss.

#include <cstddef>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scheduling/motion/hip_sample.hpp"

namespace forefeel {

class Predictor {
 public:
  virtual ~Predictor() = default;
  virtual void observe(const HipSample& sample) = 0;     // times do not go back
  virtual Prediction predict(double horizon) const = 0;  // from the last sample on
};

std::unique_ptr<Predictor> make_predictor(const std::string& name);  // InputError lists the names
std::vector<std::string> predictor_names();

// Prediction error against horizon over a motion sampled every `step` seconds [m].
struct PredictionError {
  double horizon = 0;           // [s]
  double p50 = 0, p95 = 0;      // |predicted - true|
  double within_deviation = 0;  // share of true positions within twice the deviation per axis
};
// The same while the motion comes.
class PredictionScore {
 public:
  PredictionScore(Predictor& predictor, double step,
                  std::span<const double> horizons);  // the predictor must outlive it
  void add(const Vec3& at);                           // of the next step
  std::vector<PredictionError> report() const;

 private:
  struct Ahead {
    double horizon;
    std::size_t steps;
    std::deque<Prediction> made;  // that no position was compared with yet
    std::vector<double> errors;
    std::size_t within = 0;
  };
  Predictor& predictor_;
  double step_;
  std::size_t seen_ = 0;
  std::vector<Ahead> ahead_;
};
std::vector<PredictionError> prediction_error(Predictor& predictor, const std::vector<Vec3>& motion,
                                              double step, std::span<const double> horizons);

}  // namespace forefeel
