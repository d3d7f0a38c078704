// Loading and unloading rows are named, with the width of their loop; sound rows are not. The fields are formulas.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "geometry/states/hysteresis.hpp"
#include "geometry/states/misleading.hpp"
#include "tests/support/test.hpp"

namespace {

class Rows {
 public:
  explicit Rows(unsigned seed) : random_(seed), turn_(Mat3::Identity()) {
    if (seed > 0)
      turn_ = Eigen::Quaterniond(normal(), normal(), normal(), normal()).normalized().toRotationMatrix();
    depth_ = 0.002 + 0.001 * (seed % 4);
  }
  double normal() { return normal_(random_); }
  double share() { return uniform_(random_); }
  Vec3 shake(double by) { return by * Vec3(normal(), normal(), normal()); }

  // Contact that stiffens: zero far above z = 0.
  Vec3 force(const Vec3& x) const {
    const double d = depth_ * std::log1p(std::exp(-x.z() / depth_));
    return Vec3(-40 * x.x(), -40 * x.y() * (1 + 60 * d), 300 * d + 3e4 * d * d);
  }
  // A row at x whose force is larger by the share `loop`, or less. noise: of a component [N].
  void add(const Vec3& x, double loop = 0, double noise = 0, double jitter = 0) {
    const Vec3 f = force(x);
    State row;
    row.at = turn_ * (x + shake(jitter));
    row.force = turn_ * ((1 + loop) * f + shake(noise));
    states.push_back(row);
  }
  // Presses down and up at random places, `steps` rows each way, the rows up at other depths than those down.
  void press(int places, int steps, double loop, double noise = 0, double jitter = 0, int dwell = 0) {
    for (int k = 0; k < places; ++k) {
      const double a = 0.03 * (share() - 0.5), b = 0.03 * (share() - 0.5), shift = share();
      for (int i = 0; i < steps; ++i) add({a, b, -0.012 * i / (steps - 1)}, loop / 2, noise, jitter);
      for (int i = 0; i < dwell; ++i) add({a, b, -0.012}, 0, noise, jitter + 1e-5);
      for (int i = steps; i-- > 0;) add({a, b, -0.012 * (i - shift) / (steps - 1)}, -loop / 2, noise, jitter);
    }
  }
  std::vector<State> states;

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{0, 1};
  Mat3 turn_;
  double depth_;
};

}  // namespace

TEST_CASE("loading and unloading are named hysteresis, with the width of the loop") {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const double loop = std::array{0.05, 0.1, 0.3}[seed % 3], noise = seed % 2 ? 0.01 : 0;
    CAPTURE(seed, loop, noise);
    Rows rows(seed);
    rows.press(20, 12 + int(seed), loop, noise, 1e-5, seed % 4 == 3 ? 40 : 0);
    const std::optional<Hysteresis> found = hysteresis_of(rows.states);
    REQUIRE(found);
    CHECK(found->share == Approx(loop).epsilon(0.15));
    CHECK(found->strokes == 40);
    double mean = 0;
    for (const State& row : rows.states) mean += row.force.norm() / double(rows.states.size());
    CHECK(found->width > 0.5 * loop * mean);
    CHECK(found->width < 1.5 * loop * mean);
    CHECK_THAT(hysteresis_in_words(rows.states),
               Contains(fmt::format("hysteresis: loading and unloading rows of one place differ by {:.2g} N",
                                    found->width)));
    const std::vector<std::string> lines = misleading(rows.states, 0.004);
    CHECK(std::ranges::count_if(lines, [](const auto& line) { return line.starts_with("hysteresis"); }) == 1);
    // The force on the tissue in place of that on the tip.
    std::vector<State> turned = rows.states;
    for (State& row : turned) row.force = -row.force.eval();
    REQUIRE(hysteresis_of(turned));
    CHECK(hysteresis_of(turned)->width == Approx(found->width));
    // Rows in another order tell nothing of loading.
    std::mt19937 random(seed);
    std::ranges::shuffle(rows.states, random);
    CHECK_FALSE(hysteresis_of(rows.states));
  }
  Rows one(1);
  one.press(1, 20, 0.1);
  CHECK(hysteresis_of(one.states));
}

TEST_CASE("sound rows have no hysteresis, whatever their noise, order and places") {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const double noise = std::array{0.0, 0.01, 0.1, 0.5}[seed % 4], jitter = seed % 3 ? 1e-5 : 2e-4;
    CAPTURE(seed, noise, jitter);
    Rows presses(seed), dwells(seed), sparse(seed), scattered(seed), raster(seed), path(seed);
    presses.press(1 + int(seed), 6 + int(seed) % 30, 0, noise, jitter);
    dwells.press(10, 10, 0, noise, 2e-6, 100);
    sparse.press(12, 3, 0, noise, jitter);
    for (int i = 0; i < 200; ++i)
      scattered.add(0.04 * Vec3(scattered.share() - 0.5, scattered.share() - 0.5, -0.5 * scattered.share()),
                    0, noise);
    for (int line = 0; line < 40; ++line)  // there and back
      for (int i = 0; i < 20; ++i) {
        const double along = 0.002 * (line % 2 ? 10 - i : i - 10);
        raster.add({0.005 * (line / 8 - 2), seed % 2 ? along : 0.005 * (line % 8 - 4),
                    seed % 2 ? -0.002 * (line % 8) : 0.3 * along - 0.006},
                   0, noise, jitter);
      }
    for (int i = 0; i < 600; ++i)
      path.add(
          {0.02 * std::sin(0.05 * i + seed), 0.02 * std::sin(0.071 * i), 0.006 * std::sin(0.113 * i) - 0.006},
          0, noise, jitter);
    for (const Rows* rows : {&presses, &dwells, &sparse, &scattered, &raster, &path}) {
      INFO(rows->states.size() << hysteresis_in_words(rows->states));
      CHECK_FALSE(hysteresis_of(rows->states));
    }
  }
  CHECK_FALSE(hysteresis_of({}));
  CHECK_FALSE(hysteresis_of(std::vector<State>(20)));
}
