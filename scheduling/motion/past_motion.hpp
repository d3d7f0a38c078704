#pragma once
// What predictors keep of a motion: its samples on an even grid, and the errors that their predictions had.

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <vector>

#include "scheduling/motion/hip_sample.hpp"

namespace forefeel {

// The newest positions at the times k step [m], interpolated linearly between samples.
class PastMotion {
 public:
  PastMotion(double step, std::size_t most) : step_(step), most_(most) {}
  // Returns the number of new nodes.
  std::size_t add(const HipSample& sample) {
    constexpr double rounding = 1e-9;  // [s]
    std::size_t added = 0;
    if (!seen_) begin_ = sample.t;
    for (double next; (next = begin_ + step_ * static_cast<double>(count_)) <= sample.t + rounding; ++added) {
      const double w =
          seen_ && sample.t > last_.t ? std::min((next - last_.t) / (sample.t - last_.t), 1.0) : 1;
      at_.push_back(last_.at + w * (sample.at - last_.at));
      if (at_.size() > most_) at_.pop_front();
      ++count_;
    }
    last_ = sample;
    seen_ = true;
    return added;
  }
  std::size_t size() const { return at_.size(); }
  const Vec3& operator[](std::size_t i) const { return at_[i]; }  // the oldest first
  const Vec3& back(std::size_t i) const { return at_[at_.size() - 1 - i]; }
  double step() const { return step_; }  // [s]
  double since() const {                 // the newest node [s]
    return count_ > 0 ? std::max(last_.t - begin_ - step_ * static_cast<double>(count_ - 1), 0.0) : 0;
  }
  const HipSample& last() const { return last_; }

 private:
  double step_, begin_ = 0;
  std::size_t most_, count_ = 0;
  bool seen_ = false;
  HipSample last_;
  std::deque<Vec3> at_;
};

// The deviation of predictions by horizon, measured: predictions over five horizons are kept and compared with the true
// position, and their mean square errors fade over 2 s. Between the horizons it is interpolated, beyond the last it
// grows with the horizon.
class MeasuredDeviation {
 public:
  // at_horizon: the position predicted a horizon [s] after this sample [m].
  template <class AtHorizon>
  void observe(const HipSample& sample, const AtHorizon& at_horizon) {
    constexpr double fading = 2, every = 0.005;  // [s]
    for (Probe& probe : probes_) {
      for (; !probe.made.empty() && probe.made.front().t <= sample.t; probe.made.pop_front()) {
        const double error2 = (probe.made.front().at - sample.at).squaredNorm() / 3;
        probe.error2 += (1 - std::exp(-every / fading)) * (error2 - probe.error2);
      }
    }
    if (sample.t < next_) return;
    next_ = sample.t + every;
    for (Probe& probe : probes_)
      probe.made.push_back({.t = sample.t + probe.horizon, .at = at_horizon(probe.horizon)});
  }

  double operator()(double horizon) const {
    double before = 0, deviation = least;
    for (const Probe& probe : probes_) {
      const double here = std::max(std::hypot(least, std::sqrt(probe.error2)), deviation);
      if (horizon <= probe.horizon)
        return deviation + (here - deviation) * (horizon - before) / (probe.horizon - before);
      before = probe.horizon;
      deviation = here;
    }
    return deviation * horizon / before;
  }

 private:
  static constexpr double least = 2e-4;  // [m]
  struct Probe {
    double horizon, error2;           // [s], [m^2]
    std::deque<HipSample> made = {};  // t: when to compare
  };
  std::array<Probe, 5> probes_{{{0.05, 2.5e-7}, {0.1, 1e-6}, {0.2, 4e-6}, {0.4, 1.6e-5}, {0.8, 6.4e-5}}};
  double next_ = -1e9;
};

}  // namespace forefeel
