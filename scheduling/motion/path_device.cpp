#include "scheduling/motion/path_device.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/common/error.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/path_shapes.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/motion/surface_shapes.hpp"

namespace forefeel {
namespace {

// Adds tremor and sensor noise to a motion. Both fade in over 0.25 s: the motion starts exactly at rest.
class Disturbance {
 public:
  Disturbance(double tremor, double noise, std::uint64_t seed) : noise_(noise), seed_(seed) {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < waves; ++k) {
        const std::uint64_t key = random::mix(seed, 100 + static_cast<std::uint64_t>(i * waves + k));
        wave_[i][k] = {tremor * std::sqrt(2.0 / waves), random::two_pi * (8 + 4 * random::uniform(key)),
                       random::two_pi * random::uniform(random::mix(key, 1))};
      }
  }

  Vec3 at(double t) const noexcept {
    Vec3 sum = Vec3::Zero();
    const auto tick = static_cast<std::uint64_t>(std::llround(t * 1e6));
    for (int i = 0; i < 3; ++i) {
      for (const Wave& w : wave_[i]) sum[i] += w.amplitude * std::sin(w.frequency * t + w.phase);
      if (noise_ > 0)
        sum[i] +=
            noise_ * random::normal(random::mix(random::mix(seed_, 7 + static_cast<std::uint64_t>(i)), tick));
    }
    return std::min(1.0, t / 0.25) * sum;
  }

 private:
  static constexpr int waves = 8;
  struct Wave {
    double amplitude, frequency, phase;  // [m], [rad/s], [rad]
  };
  Wave wave_[3][waves];
  double noise_;
  std::uint64_t seed_;
};

// A curve parametrised by arc length: the lead once, then the loop for ever. Each turn of more than 45 degrees counts
// as `rest` metres long, without moving.
class Curve {
 public:
  explicit Curve(const PathShape& shape, double rest = 0) {
    std::vector<Vec3> corners = shape.lead;
    if (!corners.empty() && corners.back() == shape.loop.front()) corners.pop_back();
    const std::size_t loop = corners.size();
    corners.insert(corners.end(), shape.loop.begin(), shape.loop.end());
    corners.insert(corners.end(), {shape.loop.front(), shape.loop[1]});
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
      append(corners[i], points_.empty() ? 0 : (corners[i] - points_.back()).norm());
      if (rest > 0 && i > 0 && is_turn(corners[i] - corners[i - 1], corners[i + 1] - corners[i]))
        append(corners[i], rest);
      if (i == loop) loop_start_ = length_.back();
    }
  }
  double loop_start() const { return loop_start_; }
  double loop_length() const { return length_.back() - loop_start_; }

  Vec3 at(double s) const {
    if (s <= 0) return points_.front();
    if (s > length_.back()) s = loop_start_ + std::fmod(s - loop_start_, loop_length());
    const auto upper = std::upper_bound(length_.begin(), length_.end(), s);
    const auto i =
        std::min<std::size_t>(static_cast<std::size_t>(upper - length_.begin()), length_.size() - 1);
    const double span = length_[i] - length_[i - 1];
    const double w = span > 0 ? (s - length_[i - 1]) / span : 0;
    return (1 - w) * points_[i - 1] + w * points_[i];
  }

 private:
  static bool is_turn(const Vec3& before, const Vec3& after) {
    return before.dot(after) < std::sqrt(0.5) * before.norm() * after.norm();
  }
  void append(const Vec3& p, double length) {
    length_.push_back(length_.empty() ? 0 : length_.back() + length);
    points_.push_back(p);
  }
  std::vector<Vec3> points_;
  std::vector<double> length_;
  double loop_start_ = 0;
};

// out_i = mean of the `window` values of `in` up to i; indices before the start use the first value.
std::vector<Vec3> sliding_mean(const std::vector<Vec3>& in, std::size_t window) {
  std::vector<Vec3> out(in.size());
  Vec3 sum = static_cast<double>(window) * in.front();
  for (std::size_t i = 0; i < in.size(); ++i) {
    sum += in[i] - (i >= window ? in[i - window] : in.front());
    out[i] = sum / static_cast<double>(window);
  }
  return out;
}

// The curve at constant speed, averaged twice over a short window. This rounds the corners and slows the
// motion there, makes the start smooth, and never exceeds the given speed. Positions are tabulated; a look-up
// interpolates linearly.
class PathDevice final : public Device {
 public:
  PathDevice(const PathShape& shape, double speed, double pause, Disturbance disturbance)
      : speed_(speed), disturbance_(disturbance) {
    Curve curve(shape);
    const double window = std::min(0.010, curve.loop_length() / 8);
    if (pause > 0) curve = Curve(shape, pause * speed + window);  // the average takes a window of it
    const std::size_t half = 16;
    // The step divides the loop's length, so that the table is periodic.
    const auto steps =
        std::max<std::size_t>(64, static_cast<std::size_t>(std::ceil(curve.loop_length() / (window / 32))));
    step_ = curve.loop_length() / static_cast<double>(steps);
    const std::size_t before = static_cast<std::size_t>(std::ceil(curve.loop_start() / step_)) + 2 * half + 1;
    std::vector<Vec3> table(before + steps + 1);
    for (std::size_t i = 0; i < table.size(); ++i) table[i] = curve.at(static_cast<double>(i) * step_);
    table_ = sliding_mean(sliding_mean(table, half), half);
    loop_start_ = static_cast<double>(before) * step_;
    loop_length_ = static_cast<double>(steps) * step_;
  }

  Vec3 position(double t, const Vec3&) noexcept override {
    double s = speed_ * std::max(t, 0.0);
    if (s > loop_start_) s = loop_start_ + std::fmod(s - loop_start_, loop_length_);
    const double place = s / step_;
    const std::size_t i = std::min(static_cast<std::size_t>(place), table_.size() - 2);
    const double w = place - static_cast<double>(i);
    return (1 - w) * table_[i] + w * table_[i + 1] + disturbance_.at(std::max(t, 0.0));
  }
  double duration() const override { return std::numeric_limits<double>::infinity(); }

 private:
  double speed_, step_ = 0, loop_start_ = 0, loop_length_ = 0;
  std::vector<Vec3> table_;
  Disturbance disturbance_;
};

// Scales the shape so that its farthest point is `amplitude` from rest [m].
void scale_to(double amplitude, PathShape& shape) {
  double farthest = 0;
  for (const auto* part : {&shape.lead, &shape.loop})
    for (const Vec3& p : *part) farthest = std::max(farthest, p.norm());
  for (auto* part : {&shape.lead, &shape.loop})
    for (Vec3& p : *part) p *= amplitude / farthest;
}

}  // namespace

std::unique_ptr<Device> make_path_device(const PathMotion& motion, const FactoryContext& context) {
  if (context.surface == nullptr && (motion.depth || !motion.where.empty()))
    throw InputError("device", "depth and where are of paths on a surface, expected contact.anywhere");
  if (context.surface != nullptr && motion.amplitude > 0)
    throw InputError("device",
                     "amplitude is of paths around one place, expected depth with contact.anywhere");
  PathShape shape = context.surface ? surface_shape(motion, *context.surface, context.seed)
                                    : path_shape(motion.path, context);
  if (motion.amplitude > 0) scale_to(motion.amplitude, shape);
  return std::make_unique<PathDevice>(shape, motion.speed.value_or(usual_speed), motion.pause,
                                      Disturbance(motion.tremor, motion.noise, context.seed));
}

}  // namespace forefeel
