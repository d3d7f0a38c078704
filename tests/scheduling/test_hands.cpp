// Hands that differ: drawn from the seed, and with a reaction to a force that comes as a surprise.

#include "scheduling/motion/device.hpp"
#include "scheduling/motion/hand_device.hpp"
#include "scheduling/motion/trace.hpp"
#include "scheduling/record/summary.hpp"
#include "small_body.hpp"

namespace {

HandMotion drawn() {
  return {.profile = HandName::omega,
          .target = {.path = PathName::press, .speed = 0.06},
          .traits = {.drawn = true}};
}

std::unique_ptr<Device> still_hand(const HandOptions& options) {
  return make_hand_device(profile_of(HandName::omega),
                          make_trace_device({{0, 10}, {Vec3::Zero(), Vec3::Zero()}}), options);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

TEST_CASE("hands drawn from seeds lie in their ranges, fill them, and are the same for the same seed") {
  std::vector<double> grip, zeta, mass, tremor, delay, stiffening;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    const HandMotion hand = drawn_hand(drawn(), seed), again = drawn_hand(drawn(), seed);
    REQUIRE(hand.grip == again.grip);
    REQUIRE(hand.target.tremor == again.target.tremor);
    REQUIRE_FALSE(hand.traits.drawn);
    grip.push_back(hand.grip);
    zeta.push_back(hand.traits.damping_ratio);
    mass.push_back(hand.traits.mass);
    tremor.push_back(hand.target.tremor);
    delay.push_back(hand.traits.delay);
    stiffening.push_back(hand.traits.stiffening);
  }
  // Medians of the distributions named in the header; the standard error of 4000 draws is below 2 % of a range.
  const auto check = [](const std::vector<double>& values, double low, double middle, double high) {
    const auto [least, most] = std::ranges::minmax(values);
    CAPTURE(low, high, least, most);
    CHECK(least >= low);
    CHECK(most <= high);
    CHECK(least < low + 0.05 * (high - low));
    CHECK(most > high - 0.05 * (high - low));
    CHECK(median(values) == Approx(middle).epsilon(0.06));
  };
  check(grip, 100, 300, 1000);
  check(zeta, 0.3, 0.55, 0.8);
  check(mass, 0.1, 0.3, 0.5);
  check(tremor, 50e-6, 100e-6, 200e-6);
  check(delay, 0.05, 0.075, 0.1);
  check(stiffening, 0, 0.5, 1);
  // Log-normal about 300 with sigma 0.5: 68.3 % within a factor of exp(0.5).
  const auto within = std::ranges::count_if(
      grip, [](double k) { return k > 300 * std::exp(-0.5) && k < 300 * std::exp(0.5); });
  CHECK(static_cast<double>(within) / 4000 == Approx(0.683).margin(0.03));
}

TEST_CASE("a hand that is not drawn is the one asked for, whatever the seed") {
  HandMotion plain = drawn();
  plain.traits.drawn = false;
  const HandMotion same = drawn_hand(plain, 7);
  CHECK(same.grip == 300);
  CHECK(same.traits.mass == 0.1);
  CHECK(same.target.tremor == 0);
  CHECK(to_text(DeviceSpec(plain)) == "hand:omega,target=press,grip=300,speed=0.06");
  CHECK(to_text(DeviceSpec(drawn())) == "hand:omega,target=press,grip=300,speed=0.06,drawn=yes");
}

TEST_CASE("a surprising force stiffens the grip after its delay, and the hand calms down") {
  const HandOptions usual{.grip = 200};
  HandOptions reacts = usual;
  reacts.stiffening = 1;
  reacts.delay = 0.08;
  reacts.calm = 0.2;
  const auto without = still_hand(usual), with = still_hand(reacts);
  const Vec3 force(1, 0, 0);
  for (int k = 0; k <= 3000; ++k) {
    const double t = k * 1e-3;
    const Vec3 sent =
        k < 100 ? Vec3::Zero() : force;  // sent in frame 100, felt in the frame that ends at 101 ms
    const Vec3 a = without->position(t, sent), b = with->position(t, sent);
    if (k <= 180) REQUIRE(a == b);
    // A spring twice as stiff yields half as far: 2.5 mm in place of 5 mm, less what calmed down since.
    if (k == 260) {
      CHECK(a[0] == Approx(5e-3).epsilon(0.02));
      CHECK(b[0] < 0.75 * a[0]);
      CHECK(b[0] > 0.5 * a[0]);
    }
    if (k == 3000) CHECK((a - b).norm() <= 2e-5);
  }
  // A force that creeps is no surprise.
  const auto calm = still_hand(reacts), plain = still_hand(usual);
  for (int k = 0; k <= 3000; ++k) {
    const Vec3 sent(1e-3 * k, 0, 0);
    REQUIRE(calm->position(k * 1e-3, sent) == plain->position(k * 1e-3, sent));
  }
}

TEST_CASE("a study over seeds is one over people: what the hand does differs from seed to seed") {
  SessionOptions options = virtual_options(1);
  options.workers.cost = ConstantCost{0.005};
  options.motion.device = drawn();
  std::set<double> grips;
  std::vector<double> reach;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    options.seed = seed;
    const SessionResult result = run_session(small_input(), options);
    double most = 0;
    for (const FrameRecord& frame : result.frames) most = std::max(most, frame.at.norm());
    reach.push_back(most);
    const SessionSummary summary = summarise(result, small_input(), options);
    grips.insert(summary.energy.hand.grip);
    CHECK(summary.energy.hand.tremor >= 50e-6);
  }
  CHECK(grips.size() == 5);
  const auto [least, most] = std::ranges::minmax(reach);
  CHECK(most > 1.02 * least);
}

TEST_CASE("traits outside their range are refused") {
  const auto refused = [](const HandTraits& traits, const char* what) {
    CHECK_THROWS_WITH(check(DeviceSpec(HandMotion{.traits = traits})), Contains(what));
  };
  refused({.mass = 0}, "mass is '0'");
  refused({.damping_ratio = 1.2}, "zeta is 1.2");
  refused({.stiffening = -1}, "stiffening is '-1'");
  refused({.delay = -0.1}, "delay is '-0.1'");
}
