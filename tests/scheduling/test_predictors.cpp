// Predictors against motions that they must continue exactly, and the calibration of their distributions.

#include <cmath>
#include <sstream>

#include "geometry/common/error.hpp"
#include "scheduling/motion/prediction_score.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/motion/recurrent_net.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/test.hpp"

namespace {

// Seconds `from` to `until` of a motion, a sample each millisecond.
template <class Motion>
void watch(Predictor& predictor, const Motion& motion, int from, int until) {
  for (int k = from; k <= until; ++k) predictor.observe({.t = 1e-3 * k, .at = motion(1e-3 * k)});
}

// Weights without meaning, as the numpy program that gave the numbers below made them.
std::string made_up_net() {
  std::ostringstream file;
  file.precision(17);
  file << "step,0.02\nunit,0.1\nhorizons,0.1,0.4\n";
  int count = 0;
  const auto line = [&](const std::string& name, int values) {
    file << name;
    for (int i = 0; i < values; ++i) file << ',' << std::sin(1.7 * count++ + 0.3);
    file << '\n';
  };
  for (const char gate : {'z', 'r', 'n'}) {
    line(std::string("W") + gate, 6);
    line(std::string("U") + gate, 9);
    line(std::string("b") + gate, 3);
  }
  line("V", 12);
  line("c", 4);
  return file.str();
}

}  // namespace

TEST_CASE("minimum-jerk: a movement past its peak speed is completed") {
  const Vec3 start(0.01, 0, -0.01), way(0.04, -0.03, 0.01);
  for (const double duration : {0.4, 0.7}) {
    const auto motion = [&](double t) -> Vec3 {
      const double u = std::clamp((t - 0.3) / duration, 0.0, 1.0);
      return start + (10 * std::pow(u, 3) - 15 * std::pow(u, 4) + 6 * std::pow(u, 5)) * way;
    };
    const auto predictor = make_predictor("minimum-jerk");
    int seen = -1;
    for (const double share : {0.7, 0.8, 0.95}) {
      const double now = 0.3 + share * duration;
      const int until = static_cast<int>(std::lround(1e3 * now));
      watch(*predictor, motion, seen + 1, until);
      seen = until;
      for (const double horizon : {0.02, 0.1, 0.3, 1.0}) {
        CAPTURE(duration, share, horizon);
        CHECK((predictor->predict(horizon).at - motion(1e-3 * seen + horizon)).norm() < 1e-6);
      }
    }
    // Not exact by chance: a constant velocity is millimetres off.
    const auto constant = make_predictor("constant-velocity");
    watch(*constant, motion, 0, static_cast<int>(1e3 * (0.3 + 0.7 * duration)));
    CHECK((constant->predict(0.3).at - motion(0.6 + 0.7 * duration)).norm() > 1e-3);
  }
}

TEST_CASE("autoregressive: sinusoids, of another frequency along each axis, go on") {
  const auto motion = [](double t) {
    return Vec3(0.02 * std::sin(3.1 * t), 0.03 * std::sin(5.3 * t + 1), 0.01 * std::cos(8.9 * t));
  };
  const auto predictor = make_predictor("autoregressive");
  watch(*predictor, motion, 0, 4000);
  for (const double horizon : {0.02, 0.1, 0.5, 1.0}) {
    CAPTURE(horizon);
    CHECK((predictor->predict(horizon).at - motion(4 + horizon)).norm() < 1e-6);
  }
}

TEST_CASE("past: the second period of a motion is like the first") {
  constexpr double period = 1.6;  // [s]
  const auto motion = [](double t) {
    const double u = random::two_pi * t / period;
    return Vec3(0.02 * std::sin(u) + 0.01 * std::sin(2 * u), 0.015 * std::cos(3 * u), 0.02 * std::cos(u));
  };
  const auto predictor = make_predictor("past");
  int seen = -1;
  for (const double now : {2.0, 2.4, 3.0}) {
    const int until = static_cast<int>(std::lround(1e3 * now));
    watch(*predictor, motion, seen + 1, until);
    seen = until;
    for (const double horizon : {0.05, 0.3, 1.0, 3.0}) {  // also beyond what is past
      CAPTURE(now, horizon);
      CHECK((predictor->predict(horizon).at - motion(now + horizon)).norm() < 1e-5);
    }
  }
}

TEST_CASE("network: the state and the output of a net are those of numpy") {
  const TemporaryFolder folder;
  const RecurrentNet net = read_recurrent_net(folder.write("net.csv", made_up_net()));
  Eigen::VectorXd state = net.first();
  for (int t = 0; t < 10; ++t)
    net.advance(Eigen::Vector2d(std::cos(0.5 * t), std::abs(std::sin(0.8 * t))), state);
  const Eigen::Vector3d of_numpy(-0.17824453539236773, -0.0159554248222102, 0.74401554940038);
  const Eigen::Vector4d out_of_numpy(0.3004341374204095, 0.9261085473047592, -0.5049265928118745,
                                     -1.6448234811628644);
  CHECK((state - of_numpy).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((net.output(state) - out_of_numpy).cwiseAbs().maxCoeff() < 1e-12);

  // The predictor's mean and deviation, from the net's own output for the motion so far.
  FactoryContext context;
  context.folder = folder.path();
  const auto predictor = make_predictor(Registered("network", {{"", "net.csv"}}), context);
  const auto motion = [](double t) { return Vec3(0.05 * t * t, 0, 0); };
  watch(*predictor, motion, 0, 200);
  Eigen::VectorXd x = net.first(), still = net.first();
  for (int k = 1; k <= 10; ++k) {
    const double v = (motion(0.02 * k) - motion(0.02 * k - 0.02)).x() / 0.02;
    net.advance(Eigen::Vector2d(v, v) / 0.1, x);
    net.advance(Eigen::Vector2d(0, v) / 0.1, still);
  }
  const double v = (motion(0.2) - motion(0.18)).x() / 0.02;
  const Eigen::VectorXd y = net.output(x), rest = net.output(still);
  const Prediction p = predictor->predict(0.4);
  CHECK(p.at.x() == Approx(motion(0.2).x() + 0.4 * v + 0.04 * y[1]).epsilon(1e-9));
  CHECK(p.at.y() == Approx(0.04 * rest[1]).epsilon(1e-9));
  const double deviation = 0.04 * std::sqrt((std::exp(2 * y[3]) + 2 * std::exp(2 * rest[3])) / 3);
  CHECK(p.deviation == Approx(std::hypot(2e-4, deviation)).epsilon(1e-9));

  CHECK_THROWS_AS(make_predictor("network"), InputError);
  CHECK_THROWS_WITH(make_predictor(Registered("network", {{"", "absent.csv"}}), context),
                    Catch::Contains("absent.csv"));
  folder.write("bad.csv", made_up_net() + "c,1,2\n");
  CHECK_THROWS_WITH(make_predictor(Registered("network", {{"", "bad.csv"}}), context),
                    Catch::Contains("c has 6 values, expected 4 x 1"));
}

TEST_CASE(
    "calibration: of a random walk, 50 and 90 % of the places are within the regions of its predictor") {
  constexpr double step = 1e-3, each = 1e-3;  // [s], [m] per axis and step
  struct Walk final : Predictor {
    double scale = 1;
    Vec3 last = Vec3::Zero();
    void observe(const HipSample& sample) override { last = sample.at; }
    Prediction predict(double horizon) const override {
      return {.horizon = horizon, .at = last, .deviation = scale * each * std::sqrt(horizon / step)};
    }
  };
  const double horizons[] = {0.001, 0.005};
  Walk walk, sure;
  sure.scale = 0.5;
  PredictionScore score(walk, step, horizons), too_sure(sure, step, horizons);
  constexpr int count = 20'000;
  Vec3 at = Vec3::Zero();
  for (std::uint64_t k = 0; k < count; ++k) {
    for (int i = 0; i < 3; ++i)
      at[i] += each * random::normal(random::mix(3 * k + static_cast<std::uint64_t>(i), 7));
    score.add(at);
    too_sure.add(at);
  }
  for (const PredictionError& e : score.report()) {
    CAPTURE(e.horizon);
    // Predictions that overlap are dependent: as many independent ones as horizons fit into the motion.
    const double independent = count * step / e.horizon;
    CHECK(std::abs(e.within_50 - 0.5) < 4 * std::sqrt(0.25 / independent));
    CHECK(std::abs(e.within_90 - 0.9) < 4 * std::sqrt(0.09 / independent));
  }
  CHECK(too_sure.report()[0].within_90 < 0.4);
}

TEST_CASE("a scored predictor sees the hand's velocity, as in a session") {
  struct Straight final : Predictor {
    HipSample last;
    void observe(const HipSample& sample) override { last = sample; }
    Prediction predict(double horizon) const override {
      return {.horizon = horizon, .at = last.at + horizon * last.velocity, .deviation = 1e-6};
    }
  };
  const double horizons[] = {0.02};
  Straight straight;
  PredictionScore score(straight, 1e-3, horizons);
  for (int k = 0; k < 200; ++k) score.add(Vec3(0.05, -0.02, 0.01) * (1e-3 * k));
  const PredictionError e = score.report()[0];
  CHECK(e.p50 < 1e-12);
  CHECK(e.within_90 > 0.99);  // all but that of the first position, which has no velocity
}
