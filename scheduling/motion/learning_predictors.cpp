#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "scheduling/motion/past_motion.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/motion/predictors.hpp"

namespace forefeel {

// Completion of a minimum-jerk movement (Flash and Hogan 1985). The position of one,
//   x(t) = x0 + (x1 - x0) (10 u^3 - 15 u^4 + 6 u^5),   u = (t - t0) / D
// is symmetric about its peak speed at t_p = t0 + D / 2, so that once the peak is past
//   x(t_p + s) = 2 x(t_p) - x(t_p - s)
// and neither x1 nor D needs a fit. The movement ends where it mirrors its start, at the last least speed before the
// peak, and the hand then rests. Before the peak, and where the hand has left the mirrored path, it keeps its velocity.

namespace {

class MinimumJerk final : public Predictor {
 public:
  void observe(const HipSample& sample) override {
    const std::size_t before = count_;
    count_ += past_.add(sample);
    for (std::size_t k = before; k < count_; ++k) note_speed(count_ - 1 - k);
    deviation_.observe(sample, [&](double horizon) { return at(horizon); });
  }
  Prediction predict(double horizon) const override {
    return {.horizon = horizon, .at = at(horizon), .deviation = deviation_(horizon)};
  }

 private:
  static constexpr double step = 1e-3, kept = 3;  // [s]
  static constexpr std::size_t half_width = 25;   // of the central difference that gives the speed [steps]
  static constexpr double started = 0.3,
                          slowed = 0.95;   // speed at the start and once past the peak, over the peak's
  static constexpr double slowest = 5e-3;  // [m/s] of a peak
  static constexpr double turned = 0.5;    // change of velocity over the peak speed that ends the movement

  // Velocity of the node `half_width` before the one that was `behind` the newest [m/s]. The difference is symmetric,
  // so smoothing does not move the peak.
  Vec3 velocity(std::size_t behind) const {
    return (past_.back(behind) - past_.back(behind + 2 * half_width)) / (2 * half_width * step);
  }

  // A movement starts when the hand comes to rest, or at a least speed well below the last peak. Nodes are numbered
  // from the first.
  void note_speed(std::size_t behind) {
    if (past_.size() <= behind + 2 * half_width) return;
    const double node = static_cast<double>(count_ - 1 - behind - half_width);
    const double speed = velocity(behind).norm(), last = newest_[0], before = newest_[1];
    newest_ = {speed, last};
    const bool least = last < started * peak_speed_ && last <= before && last < speed;
    if (speed < slowest || least) {
      if (least || !resting_) start_ = least ? node - 1 : node;
      resting_ = speed < slowest;
      peak_speed_ = resting_ ? 0 : speed;
      peak_ = none;
    } else if (speed > peak_speed_) {
      resting_ = false;
      peak_speed_ = speed;
      peak_ = none;
    } else if (last == peak_speed_ && peak_ == none) {  // the vertex of the parabola through three speeds
      const double bend = before - 2 * last + speed;
      peak_ = node - 1 + (bend < 0 ? 0.5 * (before - speed) / bend : 0.0);
    }
    is_past_peak_ = peak_ != none && speed < slowed * peak_speed_;
  }

  // The position at a time, in steps from the first node; held before the oldest.
  Vec3 at_node(double node) const {
    const double place = std::clamp(node - static_cast<double>(count_ - past_.size()), 0.0,
                                    static_cast<double>(past_.size() - 1));
    const auto below = std::min(static_cast<std::size_t>(place), past_.size() - 1);
    const auto above = std::min(below + 1, past_.size() - 1);
    return past_[below] + (place - static_cast<double>(below)) * (past_[above] - past_[below]);
  }

  Vec3 at(double horizon) const {
    const Vec3 now = past_.last().at;
    constexpr std::size_t recent = 30;  // [steps] over which the velocity is taken
    if (past_.size() < 2) return now;
    const std::size_t span = std::min(recent, past_.size() - 1);
    const Vec3 speed = (past_.back(0) - past_.back(span)) / (static_cast<double>(span) * step);
    const double here = static_cast<double>(count_ - 1) + past_.since() / step;
    if (is_past_peak_) {
      const auto mirrored = [&](double node) {
        return Vec3(-at_node(2 * peak_ - std::min(node, 2 * peak_ - start_)));
      };
      const double back = static_cast<double>(span);
      const Vec3 mirrored_speed = (mirrored(here) - mirrored(here - back)) / (back * step);
      if ((mirrored_speed - speed).norm() < turned * peak_speed_)
        return now + mirrored(here + horizon / step) - mirrored(here);
    }
    return now + horizon * speed;
  }

  static constexpr double none = -1;
  PastMotion past_{step, static_cast<std::size_t>(kept / step)};
  std::size_t count_ = 0;           // nodes seen
  double start_ = 0, peak_ = none;  // [steps]
  double peak_speed_ = 0;           // [m/s]
  bool resting_ = true, is_past_peak_ = false;
  std::array<double, 2> newest_{};  // speeds, the newest first [m/s]
  MeasuredDeviation deviation_;
};

}  // namespace

std::unique_ptr<Predictor> make_minimum_jerk(FactoryContext&) {
  return std::make_unique<MinimumJerk>();
}

// Each axis follows an autoregressive model of its displacements d_k over 20 ms,
//   d_k = sum_i a_i d_{k-i},   i = 1..4
// fitted by recursive least squares that forgets over 4 s: R = g R + D D^T, r = g r + D d. A slight pull towards a
// constant velocity, a = (1, 0, 0, 0), decides where the motion does not. Displacements beyond twice the largest of
// late are cut, so that an unstable fit stays bounded.

namespace {

class Autoregressive final : public Predictor {
 public:
  void observe(const HipSample& sample) override {
    for (std::size_t n = past_.add(sample); n > 0; --n) learn(n - 1);
    if (!ahead_.empty() || past_.size() > 1) continue_motion();
    deviation_.observe(sample, [&](double horizon) { return at(horizon); });
  }
  Prediction predict(double horizon) const override {
    return {.horizon = horizon, .at = at(horizon), .deviation = deviation_(horizon)};
  }

 private:
  static constexpr int order = 4;
  static constexpr double step = 0.02, memory = 4, longest = 3;  // [s]
  using Row = Eigen::Matrix<double, order, 1>;
  struct Axis {
    Eigen::Matrix<double, order, order> normal = Eigen::Matrix<double, order, order>::Zero();
    Row right = Row::Zero(), fit = Row::Unit(0);
    double largest = 0;  // |d| of late [m]
  };

  double moved(std::size_t behind, int k) const { return past_.back(behind)[k] - past_.back(behind + 1)[k]; }
  Row row(std::size_t behind, int k) const {
    Row row;
    for (int i = 0; i < order; ++i) row[i] = moved(behind + static_cast<std::size_t>(i), k);
    return row;
  }

  void learn(std::size_t behind) {
    fresh_ = false;
    if (past_.size() < behind + order + 2) return;
    constexpr double relative = 1e-10, absolute = 1e-16;  // of the pull; [m^2]
    const double keep = std::exp(-step / memory);
    for (int k = 0; k < 3; ++k) {
      Axis& axis = axes_[static_cast<std::size_t>(k)];
      const Row before = row(behind + 1, k);
      const double now = moved(behind, k);
      axis.normal = keep * axis.normal + before * before.transpose();
      axis.right = keep * axis.right + now * before;
      axis.largest = std::max(keep * axis.largest, std::abs(now));
      const double pull = relative * axis.normal.trace() + absolute;
      auto pulled = axis.normal;
      pulled.diagonal().array() += pull;
      axis.fit = pulled.ldlt().solve(axis.right + pull * Row::Unit(0));
    }
  }

  // The nodes ahead, the newest known one first.
  void continue_motion() {
    if (fresh_) return;
    fresh_ = true;
    constexpr auto count = static_cast<std::size_t>(longest / step);
    ahead_.assign(count + 1, past_.back(0));
    for (int k = 0; k < 3; ++k) {
      const Axis& axis = axes_[static_cast<std::size_t>(k)];
      Row row = Row::Zero();
      for (int i = 0; i < order && past_.size() > static_cast<std::size_t>(i) + 1; ++i)
        row[i] = moved(static_cast<std::size_t>(i), k);
      const double bound = std::max(2 * axis.largest, std::abs(row[0]));
      for (std::size_t n = 1; n <= count; ++n) {
        const double next = std::clamp(axis.fit.dot(row), -bound, bound);
        for (int i = order - 1; i > 0; --i) row[i] = row[i - 1];
        row[0] = next;
        ahead_[n][k] = ahead_[n - 1][k] + next;
      }
    }
  }

  // Cubic through the four nodes around a time, in steps after the newest node.
  Vec3 node(double place) const {
    const auto last = static_cast<double>(ahead_.size() - 1);
    if (place >= last) return ahead_.back() + (place - last) * (ahead_.back() - ahead_[ahead_.size() - 2]);
    const auto i = static_cast<std::size_t>(place);
    const double w = place - static_cast<double>(i);
    const Vec3& b = ahead_[i];
    const Vec3& c = ahead_[i + 1];
    const Vec3 a = i > 0 ? ahead_[i - 1] : past_.size() > 1 ? past_.back(1) : b;
    const Vec3 d = i + 2 < ahead_.size() ? ahead_[i + 2] : Vec3(2 * c - b);
    return b + w * (c - b) + w * (1 - w) / 6 * ((w - 2) * (a - 2 * b + c) - (w + 1) * (b - 2 * c + d));
  }
  Vec3 at(double horizon) const {
    if (ahead_.empty()) return past_.last().at;
    const double now = past_.since() / step;
    return past_.last().at + node(now + horizon / step) - node(now);
  }

  PastMotion past_{step, order + 8};
  std::array<Axis, 3> axes_;
  std::vector<Vec3> ahead_;
  bool fresh_ = false;
  MeasuredDeviation deviation_;
};

}  // namespace

std::unique_ptr<Predictor> make_autoregressive(FactoryContext&) {
  return std::make_unique<Autoregressive>();
}

// The nearest past motion in delay coordinates (Farmer and Sidorowich 1987): the times j of the last 40 s at which the
// hand was at the places, and 0.1 and 0.2 s before at those, where it is and was now. The hand moves as it did then:
//   x(t + s) = x(t) + sum_j w_j (x(t_j + s) - x(t_j)),   w_j ~ exp(-d_j^2 / 2 d_1^2)
// d_j: root mean square distance of the three places, d_1 the least. If t_j + s is not past yet, the motion from t_j to
// now repeats. Where nothing near is known (d_1 > 3 mm) the hand rather keeps its velocity.

namespace {

class NearestPast final : public Predictor {
 public:
  void observe(const HipSample& sample) override {
    if (past_.add(sample) > 0) search();
    deviation_.observe(sample, [&](double horizon) { return at(horizon); });
  }
  Prediction predict(double horizon) const override {
    return {.horizon = horizon, .at = at(horizon), .deviation = deviation_(horizon)};
  }

 private:
  static constexpr double step = 0.01, kept = 40;       // [s]
  static constexpr std::size_t delay = 10, delays = 3;  // [steps]
  static constexpr std::size_t apart = 20,
                               youngest = 50;  // of neighbours from each other and from now [steps]
  static constexpr std::size_t neighbours = 5;
  static constexpr double near = 3e-3, exact = 1e-9;  // [m]
  struct Neighbour {
    std::size_t behind;  // the newest node [steps]
    double weight;
  };

  void search() {
    found_.clear();
    trusted_ = 0;
    constexpr std::size_t before = (delays - 1) * delay;
    if (past_.size() < youngest + before + 1) return;
    const std::size_t last = past_.size() - before;  // steps behind
    distance2_.assign(last, 0.0);
    for (std::size_t d = 0; d < delays; ++d) {
      const Vec3 now = past_.back(d * delay);
      for (std::size_t b = youngest; b < last; ++b)
        distance2_[b] += (past_.back(b + d * delay) - now).squaredNorm() / delays;
    }
    double first = 0, sum = 0;
    for (std::size_t n = 0; n < neighbours; ++n) {
      const auto best = std::min_element(distance2_.begin() + youngest, distance2_.end());
      if (!(*best < taken)) break;
      if (n == 0) first = std::sqrt(*best) + exact;
      const double weight = std::exp(-0.5 * *best / (first * first));
      const auto behind = static_cast<std::size_t>(best - distance2_.begin());
      found_.push_back({behind, weight});
      sum += weight;
      for (std::size_t b = std::max(behind, youngest + apart) - apart; b < std::min(behind + apart, last);
           ++b)
        distance2_[b] = taken;
    }
    for (Neighbour& one : found_) one.weight /= sum;
    trusted_ = 1 / (1 + first * first / (near * near));
  }

  // Way from the node `behind` the newest within the steps after it; the way until now repeats [m].
  Vec3 after(std::size_t behind, double steps) const {
    const Vec3 from = past_.back(behind);
    const auto period = static_cast<double>(behind);
    const double times = std::floor(steps / period);
    const Vec3 repeats = times * (past_.back(0) - from);
    const double rest = steps - times * period;
    const auto whole = std::min(static_cast<std::size_t>(rest), behind - 1);
    const Vec3& a = past_.back(behind - whole);
    const Vec3& b = past_.back(behind - whole - 1);
    return repeats + a + (rest - static_cast<double>(whole)) * (b - a) - from;
  }

  Vec3 at(double horizon) const {
    const Vec3 now = past_.last().at;
    if (past_.size() < 2) return now;
    const std::size_t span = std::min<std::size_t>(3, past_.size() - 1);
    const Vec3 keeps = horizon / (static_cast<double>(span) * step) * (past_.back(0) - past_.back(span));
    Vec3 moves = Vec3::Zero();
    const double since = past_.since() / step;
    for (const Neighbour& one : found_)
      moves += one.weight * (after(one.behind, since + horizon / step) - after(one.behind, since));
    return now + trusted_ * moves + (1 - trusted_) * keeps;
  }

  static constexpr double taken = 1e9;
  PastMotion past_{step, static_cast<std::size_t>(kept / step)};
  std::vector<double> distance2_;
  std::vector<Neighbour> found_;
  double trusted_ = 0;  // share of the past motion, not of the velocity
  MeasuredDeviation deviation_;
};

}  // namespace

std::unique_ptr<Predictor> make_past(FactoryContext&) {
  return std::make_unique<NearestPast>();
}

}  // namespace forefeel
