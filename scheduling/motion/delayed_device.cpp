#include "scheduling/motion/delayed_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "geometry/common/dense.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

constexpr double longest_delay = 0.1;  // [s]

class DelayedDevice final : public Device {
 public:
  DelayedDevice(std::unique_ptr<Device> device, double frame, std::size_t late)
      : device_(std::move(device)), frame_(frame), waiting_(late, Vec3::Zero()) {}

  Vec3 position(double t, const Vec3& force) noexcept override {
    if (t < last_) std::ranges::fill(waiting_, Vec3::Zero());
    // Frames that the loop skipped held the same force.
    const auto passed =
        static_cast<std::size_t>(std::clamp(std::llround((t - last_) / frame_), 1LL, 100000LL));
    last_ = t;
    Vec3 arrived = force;
    for (std::size_t i = 0; i < std::min(passed, waiting_.size()); ++i) {
      arrived = waiting_[next_];
      waiting_[next_] = force;
      next_ = (next_ + 1) % waiting_.size();
    }
    if (passed > waiting_.size()) arrived = force;
    return device_->position(t, arrived);
  }
  double duration() const override { return device_->duration(); }
  bool answers_force() const override { return device_->answers_force(); }
  DeviceLimits limits() const override {
    DeviceLimits limits = device_->limits();
    const double boundary = delayed_limit(limits.plant, frame_, waiting_.size());
    if (std::isnan(boundary)) return limits;
    // The plant without its delay would promise too much.
    limits.stiffness = boundary;
    limits.plant = {.resolution = limits.plant.resolution, .friction = limits.plant.friction};
    return limits;
  }

 private:
  std::unique_ptr<Device> device_;
  double frame_, last_ = 0;
  std::vector<Vec3> waiting_;  // a ring of the forces under way
  std::size_t next_ = 0;
};

// e^(A T), A = (0 1; -k/m -b/m): (x, v) of a free mass, damper and spring after the time T. With s = b / 2m, B = A + s
// and w^2 = k/m - s^2 it is e^(-sT) (cos wT + B sin(wT) / w), since B^2 = -w^2.
Eigen::Matrix2d swung(double m, double b, double k, double time) {
  const double s = b / (2 * m), square = k / m - s * s, turn = std::sqrt(std::abs(square)) * time;
  const double even = square > 0 ? std::cos(turn) : std::cosh(turn);
  const double odd = turn > 1e-9 ? time * (square > 0 ? std::sin(turn) : std::sinh(turn)) / turn : time;
  const Eigen::Matrix2d shifted = (Eigen::Matrix2d() << s, 1, -k / m, -b / m + s).finished();
  return std::exp(-s * time) * (even * Eigen::Matrix2d::Identity() + odd * shifted);
}

// Largest modulus of the eigenvalues of one frame of (x, v, F_{k-1}, ..., F_{k-n}) under F_k = -K x_k.
double growth(const Eigen::Matrix2d& free, double plant_stiffness, double stiffness, std::size_t late) {
  const auto n = static_cast<Eigen::Index>(late) + 2;
  Eigen::MatrixXd map = Eigen::MatrixXd::Zero(n, n);
  map.topLeftCorner<2, 2>() = free;
  const Eigen::Vector2d push = (Eigen::Matrix2d::Identity() - free).col(0) / plant_stiffness;
  if (late == 0) {
    map.topLeftCorner<2, 1>() -= stiffness * push;
  } else {
    map.block<2, 1>(0, n - 1) = push;
    map(2, 0) = -stiffness;
    for (Eigen::Index i = 3; i < n; ++i) map(i, i - 1) = 1;
  }
  return spectral_radius_of(map);
}

}  // namespace

std::unique_ptr<Device> make_delayed_device(std::unique_ptr<Device> device, double delay, double frame) {
  const double frames = delay / frame;
  if (!(delay >= 0) || delay > longest_delay || std::abs(frames - std::round(frames)) > 1e-6)
    throw InputError("delay", fmt::format("is {:g} s, expected whole frames of {:g} s, at most {:g} s", delay,
                                          frame, longest_delay));
  const auto late = static_cast<std::size_t>(std::llround(frames));
  if (late == 0) return device;
  return std::make_unique<DelayedDevice>(std::move(device), frame, late);
}

double delayed_limit(const LoopPlant& plant, double frame, std::size_t frames_late) {
  if (frames_late == 0) return sampled_limit(plant, frame);
  const double m = plant.mass, b = plant.damping, k = plant.stiffness;
  if (!(m > 0 && b >= 0 && k > 0)) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::Matrix2d free = swung(m, b, k, frame);
  double stable = 0, unstable = std::max(1.0, 4 * sampled_limit(plant, frame));
  if (growth(free, k, unstable, frames_late) <= 1) return unstable;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (stable + unstable);
    (growth(free, k, middle, frames_late) < 1 ? stable : unstable) = middle;
  }
  return stable;
}

}  // namespace forefeel
