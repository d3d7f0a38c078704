#include "scheduling/record/stability.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

#include "scheduling/motion/hand_device.hpp"
#include "scheduling/motion/motion_options.hpp"

namespace forefeel {
namespace {

using Frames = std::span<const FrameRecord>;

constexpr double rounding = 1e-12;  // of sums of energies [J], [1]
constexpr double slowest = 5;       // lowest frequency that does not belong to the prescribed motion [Hz]
constexpr double smoothing = 0.1;   // [s]
constexpr std::size_t extrema = 7;  // of three periods
constexpr double pair_growth = 1.05, whole_growth = 1.5;

void note(StabilityReport& report, double t) {
  report.stable = false;
  if (!(report.since <= t)) report.since = t;
}

// Quantum of the frames (first, last], from the sums of |dF|.
class Quantum {
 public:
  Quantum(Frames frames, double resolution) : sums_(frames.size(), 0) {
    for (std::size_t k = 0; k < frames.size(); ++k) {
      largest_ = std::max(largest_, frames[k].sent.norm());
      if (k > 0) sums_[k] = sums_[k - 1] + (frames[k].sent - frames[k - 1].sent).norm();
    }
    scale_ = std::sqrt(3.0) / 2 * (std::isfinite(resolution) ? resolution : 0);
  }
  double of(std::size_t first, std::size_t last) const {
    return scale_ * (2 * largest_ + sums_[last] - sums_[first]);
  }

 private:
  std::vector<double> sums_;
  double largest_ = 0, scale_ = 0;
};

void observe_energy(Frames frames, const Quantum& quantum, std::size_t second, StabilityReport& report) {
  double energy = 0, deficit = 0, most_force = 0;
  std::vector<double> deficits(frames.size(), 0);
  std::deque<std::size_t> least;  // of the second before, the deficit rising from front to back
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const FrameRecord& f = frames[k];
    most_force = std::max(most_force, std::max(f.undamped.norm(), f.sent.norm()));
    if (k > 0) {
      const Vec3 step = f.at - frames[k - 1].at;
      const double put_in = -0.5 * (f.sent + frames[k - 1].sent).dot(step);
      energy = std::min(energy + put_in, most_force * f.at.norm());
      report.put_in += std::max(0.0, put_in);
      report.given_back += std::max(0.0, -put_in);
      report.hold -= 0.5 * (f.sent - frames[k - 1].sent).dot(step);
    }
    const double now = std::max(0.0, -energy);
    report.generated_in[f.label] += std::max(0.0, now - deficit);
    deficits[k] = deficit = now;
    while (!least.empty() && deficits[least.back()] >= now) least.pop_back();
    least.push_back(k);
    while (least.front() + second < k) least.pop_front();
    const double generated = now - deficits[least.front()] - quantum.of(least.front(), k);
    if (generated > rounding * (1 + report.put_in)) note(report, f.t);
    report.generated = std::max(report.generated, generated);
  }
}

void observe_switches(Frames frames, StabilityReport& report) {
  double one = 0;
  const auto finish = [&] {
    report.by_switches += std::max(0.0, one);
    report.by_a_switch = std::max(report.by_a_switch, one);
    one = 0;
  };
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const FrameRecord &a = frames[k - 1], &b = frames[k];
    if (b.step.took_model) finish();
    one += 0.5 * (b.force - b.undamped + a.force - a.undamped).dot(b.at - a.at);
  }
  finish();
}

// The mean over up to `half` neighbours on both sides, fewer at the ends.
std::vector<double> smoothed(const std::vector<double>& values, std::size_t half) {
  std::vector<double> sums(values.size() + 1, 0), out(values.size());
  for (std::size_t k = 0; k < values.size(); ++k) sums[k + 1] = sums[k] + values[k];
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::size_t width = std::min({half, k, values.size() - 1 - k});
    out[k] = (sums[k + width + 1] - sums[k - width]) / static_cast<double>(2 * width + 1);
  }
  return out;
}

std::vector<double> unexplained(Frames frames, int axis, double frame) {
  std::vector<double> x(frames.size());
  std::ranges::transform(frames, x.begin(), [axis](const FrameRecord& f) { return f.at[axis]; });
  const auto half = static_cast<std::size_t>(std::max(1.0, smoothing / frame / 2));
  const std::vector<double> smooth = smoothed(smoothed(x, half), half);
  for (std::size_t k = 0; k < x.size(); ++k) x[k] -= smooth[k];
  return x;
}

struct Extremum {
  std::size_t at;
  double size;
};

// The largest |value| between each two changes of sign.
std::vector<Extremum> extrema_of(const std::vector<double>& values) {
  std::vector<Extremum> found;
  double sign = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double v = values[k];
    if (v == 0) continue;
    if (v * sign <= 0)
      found.push_back({k, std::abs(v)});
    else if (std::abs(v) > found.back().size)
      found.back() = {k, std::abs(v)};
    sign = v;
  }
  return found;
}

bool swings_up(std::span<const Extremum> run, double floor) {
  if (run.back().size <= floor || run.back().size < whole_growth * run.front().size) return false;
  double shortest = 1e300, longest = 0;
  for (std::size_t i = 1; i < run.size(); ++i) {
    const auto length = static_cast<double>(run[i].at - run[i - 1].at);
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
    if (i > 1 && run[i].size < pair_growth * run[i - 2].size) return false;
  }
  return longest <= 2 * shortest + 1;  // a frame of rounding
}

void observe_growth(Frames frames, const std::vector<double>& values, double floor, std::size_t edge,
                    StabilityReport& report) {
  const std::vector<Extremum> all = extrema_of(values);
  for (std::size_t i = 0; i + extrema <= all.size(); ++i) {
    const auto run = std::span(all).subspan(i, extrema);
    // Near the ends the smoothing uses fewer frames, so extrema there are not judged.
    if (run.front().at < edge || run.back().at + edge >= values.size() || !swings_up(run, floor)) continue;
    note(report, frames[run.back().at].t);
    const double growth = std::cbrt(run.back().size / run.front().size);
    if (!(report.growth >= growth)) report.growth = growth;
  }
}

// The frequency with the greatest power in values [first, first + n), summed over the axes.
double dominant_frequency(const std::array<std::vector<double>, 3>& axes, std::size_t first, std::size_t n,
                          double frame) {
  double most = 0, best = unknown;
  const double length = static_cast<double>(n);
  const auto first_bin = static_cast<std::size_t>(std::max(1.0, std::ceil(slowest * length * frame)));
  for (std::size_t bin = first_bin; bin <= n / 2; ++bin) {
    const double turn = 2 * M_PI * static_cast<double>(bin) / length, c = 2 * std::cos(turn);
    double power = 0;
    for (const std::vector<double>& values : axes) {  // Goertzel's recursion
      double a = 0, b = 0;
      for (std::size_t k = first; k < first + n; ++k) {
        const double next = values[k] + c * a - b;
        b = a;
        a = next;
      }
      power += a * a + b * b - c * a * b;
    }
    if (power > most) {
      most = power;
      best = static_cast<double>(bin) / (length * frame);
    }
  }
  return best;
}

void observe_spectrum(const std::array<std::vector<double>, 3>& axes, std::size_t second, double frame,
                      double floor, StabilityReport& report) {
  const std::size_t size = axes[0].size(), n = std::min(second, size);
  std::vector<double> sums(size + 1, 0);
  for (std::size_t k = 0; k < size; ++k)
    sums[k + 1] = sums[k] + axes[0][k] * axes[0][k] + axes[1][k] * axes[1][k] + axes[2][k] * axes[2][k];
  std::size_t strongest = 0;
  for (std::size_t k = 0; k + n <= size; ++k)
    if (sums[k + n] - sums[k] > sums[strongest + n] - sums[strongest]) strongest = k;
  const double power = sums[strongest + n] - sums[strongest];
  report.amplitude = std::sqrt(std::max(0.0, power) / static_cast<double>(n));
  if (report.amplitude > floor) report.frequency = dominant_frequency(axes, strongest, n, frame);
}

}  // namespace

HandNumbers hand_numbers(const HandMotion& motion) {
  const HandTraits& usual = motion.traits;
  const HandProfile& profile = profile_of(motion.profile);
  return {.grip = motion.grip,
          .damping = 2 * usual.damping_ratio * std::sqrt(motion.grip * usual.mass),
          .mass = usual.mass,
          .tremor = std::hypot(motion.target.tremor, motion.target.noise),
          .resolution = profile.resolution,
          .stiffness = profile.stiffness};
}

StabilityReport judge_stability(Frames frames, const HandNumbers& hand, double frame) {
  StabilityReport report;
  if (frames.empty()) return report;
  const auto second = static_cast<std::size_t>(std::max(1.0, std::round(1 / frame)));
  observe_energy(frames, Quantum(frames, hand.resolution), second, report);
  observe_switches(frames, report);
  // Beats of tremor and noise, and a few steps of the encoder, do not count as an oscillation of the loop.
  const double floor =
      std::max(8 * (std::isfinite(hand.resolution) ? hand.resolution : 0), 5 * hand.tremor) + 1e-6;
  std::array<std::vector<double>, 3> axes;
  for (int i = 0; i < 3; ++i) {
    axes[static_cast<std::size_t>(i)] = unexplained(frames, i, frame);
    observe_growth(frames, axes[static_cast<std::size_t>(i)], floor,
                   static_cast<std::size_t>(smoothing / frame), report);
  }
  observe_spectrum(axes, second, frame, floor, report);
  return report;
}

}  // namespace forefeel
