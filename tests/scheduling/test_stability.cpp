// The verdict on stability, on motions whose energy and growth are known by hand.

#include "scheduling/motion/device.hpp"
#include "scheduling/motion/hand_device.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/record/stability.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "scheduling/render/safety.hpp"
#include "small_body.hpp"

namespace {

constexpr double frame = 1e-3;

// A spring of stiffness k pressed along z to x(t), in frames of 1 ms.
std::vector<FrameRecord> pressed(double seconds, double k, const std::function<double(double)>& x) {
  std::vector<FrameRecord> frames;
  for (int i = 0; i * frame < seconds; ++i) {
    FrameRecord f{.t = i * frame, .at = Vec3(0, 0, x(i * frame))};
    f.force = f.sent = f.undamped = -k * f.at;
    frames.push_back(f);
  }
  return frames;
}

double slow(double t) {
  return -0.01 * (1 - std::cos(2 * M_PI * 0.5 * t));
}

struct Press final : Device {
  Vec3 position(double t, const Vec3&) noexcept override { return {0, 0, -0.01 * (1 - std::cos(6 * t))}; }
  double duration() const override { return 1e9; }
};

// 3 s of a spring in the loop with an omega.3 in a hand.
StabilityReport in_hand(double stiffness, double grip) {
  const HandProfile& omega = profile_of(HandName::omega);
  const auto hand = make_hand_device(omega, std::make_unique<Press>(), {.grip = grip});
  Safety safety({.force_limit = omega.force_limit}, frame);
  std::vector<FrameRecord> frames;
  Vec3 sent = Vec3::Zero();
  for (int k = 0; k < 3000; ++k) {
    FrameRecord f{.t = k * frame, .at = hand->position(k * frame, sent)};
    f.force = f.undamped = -stiffness * f.at;
    f.sent = sent = safety.apply(f.force, f.at, f.t, 0);
    frames.push_back(f);
  }
  return judge_stability(frames, {.resolution = omega.resolution}, frame);
}

}  // namespace

TEST_CASE("a spring that is pressed slowly is stable, and its held forces add K dx^2 / 2 per frame") {
  const double k = 700;
  const auto frames = pressed(4, k, slow);
  const StabilityReport report = judge_stability(frames, {}, frame);
  CHECK(report.stable);
  CHECK(std::isnan(report.since));
  CHECK(report.generated <= 1e-12);
  double hold = 0, in = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const double dx = frames[i].at[2] - frames[i - 1].at[2];
    hold += k * dx * dx / 2;
  }
  in = 2 * k / 2 * 0.02 * 0.02;  // pressed twice to 2 cm
  CHECK(report.hold == Approx(hold).epsilon(1e-9));
  CHECK(report.put_in == Approx(in).epsilon(1e-4));
  CHECK(report.given_back == Approx(in).epsilon(1e-4));
}

TEST_CASE("a swing that grows is unstable from its third period, one that decays or stays is not") {
  const auto with = [&](double size, double rate) {
    return pressed(1.2, 700,
                   [=](double t) { return size * std::exp(rate * t) * std::sin(2 * M_PI * 40 * t); });
  };
  const HandNumbers hand{.resolution = 1e-5};
  const StabilityReport grows = judge_stability(with(1e-6, 6), hand, frame);  // 16 % per period of 25 ms
  CHECK_FALSE(grows.stable);
  CHECK(grows.since == Approx(std::log(81.0) / 6).margin(0.03));  // above the floor of 81 um
  CHECK(grows.frequency == Approx(40).margin(1.5));
  CHECK(grows.growth == Approx(std::exp(6 * 0.025)).epsilon(0.03));
  CHECK(judge_stability(with(1e-3, -6), hand, frame).stable);
  CHECK(judge_stability(with(1e-3, 0), hand, frame).stable);
}

TEST_CASE("a loop that gives more than it was given is unstable, by the energy of its hysteresis") {
  // Pressed at 500 N/m and released at 700 N/m from 2 cm: 0.2 * 0.02^2 / 2 kJ beyond what was put in.
  std::vector<FrameRecord> frames = pressed(2, 1, slow);
  for (FrameRecord& f : frames) f.force = f.sent = f.undamped = -(f.t <= 1 ? 500 : 700) * f.at;
  const StabilityReport report = judge_stability(frames, {.resolution = 1e-5}, frame);
  CHECK_FALSE(report.stable);
  const double extra = 200 * 0.02 * 0.02 / 2;
  const double quantum = std::sqrt(3.0) / 2 * 1e-5 * (2 * 14 + 14 + 4);  // at most
  CHECK(report.generated <= extra * (1 + 1e-4));
  CHECK(report.generated >= extra - quantum);
  CHECK(report.since > 1);
  double labels = 0;
  for (const double joule : report.generated_in.values) labels += joule;
  CHECK(labels == Approx(extra).epsilon(1e-3));
  // The other way round the hand loses energy, and nothing is generated.
  for (FrameRecord& f : frames) f.force = f.sent = f.undamped = -(f.t <= 1 ? 700 : 500) * f.at;
  CHECK(judge_stability(frames, {.resolution = 1e-5}, frame).stable);
}

TEST_CASE("positions rounded by an encoder are within its quantum, and tremor is no swing of the loop") {
  const double r = 6e-5;
  const auto rounded = pressed(6, 900, [r](double t) { return r * std::nearbyint(slow(t) / r); });
  CHECK(judge_stability(rounded, {.resolution = r}, frame).stable);
  const auto beat = pressed(6, 900, [](double t) {
    return slow(t) + 2e-4 * std::sin(2 * M_PI * 9 * t) * std::sin(2 * M_PI * 0.7 * t);
  });
  CHECK(judge_stability(beat, {.tremor = 1.1e-4, .resolution = r}, frame).stable);
  CHECK(judge_stability({}, {}, frame).stable);
}

TEST_CASE("the verdict is said first, stands in the columns of studies, and is absent without a hand") {
  SessionOptions options = virtual_options(2);
  SessionResult result;
  result.frames = pressed(2, 1, slow);
  for (FrameRecord& f : result.frames) f.force = f.sent = f.undamped = -(f.t <= 1 ? 500 : 700) * f.at;
  const auto value = [](const SessionSummary& summary, const std::string& key) {
    for (const Column& column : later_columns(summary))
      if (column.name == "stability." + key) return column.value;
    FAIL("no column " << key);
    return ColumnValue();
  };
  const SessionSummary path = summarise(result, small_input(), options);
  CHECK_FALSE(path.energy.stability);
  CHECK(value(path, "stable") == ColumnValue());
  CHECK(value(path, "generated_J") == ColumnValue());
  options.motion.device = HandMotion{.profile = HandName::omega, .grip = 100};
  const SessionSummary hand = summarise(result, small_input(), options);
  CHECK(value(hand, "stable") == ColumnValue(false));
  CHECK(value(hand, "grip") == ColumnValue(100.0));
  CHECK_THAT(attention(hand).at(0), Catch::StartsWith("ran, but unstable at 1.") && Contains(" J "));
}

TEST_CASE(
    "the boundary of stability that the verdict finds is at Colgate's K = 2 b / T or above, and near it") {
  for (const double grip : {100, 300, 800}) {
    double stable = 100, unstable = 98e3;
    CHECK(in_hand(unstable, grip).generated > 0.5);
    while (unstable / stable > 1.02) {
      const double middle = std::sqrt(stable * unstable);
      (in_hand(middle, grip).stable ? stable : unstable) = middle;
    }
    const HandOptions usual;
    const double damping = 2 * usual.damping_ratio * std::sqrt(grip * usual.mass);
    const double published = 2 * damping / frame;  // sufficient for any operator (Colgate and Schenkel 1997)
    CAPTURE(grip, stable, published);
    CHECK(stable > 0.9 * published);
    CHECK(stable < 4 * published);
  }
}
