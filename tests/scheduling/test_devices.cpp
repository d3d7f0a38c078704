#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "geometry/common/error.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/hand_device.hpp"
#include "small_body.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace forefeel;

namespace {

const DeviceContext context{.box = {Vec3(-0.036, -0.036, -0.036), Vec3(0.036, 0.036, 0.024)},
                            .inward = Vec3(0.1, 0.2, -1).normalized(),
                            .seed = 3,
                            .folder = {}};

std::vector<Vec3> motion(Device& device, double seconds, double step = 1e-3) {
  std::vector<Vec3> x;
  for (std::size_t k = 0; static_cast<double>(k) * step <= seconds; ++k)
    x.push_back(device.position(static_cast<double>(k) * step, Vec3::Zero()));
  return x;
}

std::string message(const std::string& spec, const DeviceContext& where = context) {
  try {
    make_device(spec, where);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

}  // namespace

TEST_CASE("every path starts at rest, keeps to its speed and is smooth") {
  for (const std::string& name : path_names()) {
    CAPTURE(name);
    for (const double speed : {0.02, 0.06}) {
      const auto device = make_device("path:" + name + ",speed=" + std::to_string(speed), context);
      const auto x = motion(*device, 20);
      CHECK(x.front() == Vec3::Zero());
      CHECK(device->duration() == std::numeric_limits<double>::infinity());
      double fastest = 0, travel = 0, jerk = 0;
      for (std::size_t k = 1; k < x.size(); ++k) {
        REQUIRE(x[k].allFinite());
        fastest = std::max(fastest, (x[k] - x[k - 1]).norm() / 1e-3);
        travel += (x[k] - x[k - 1]).norm();
        if (k > 1) jerk = std::max(jerk, (x[k] - 2 * x[k - 1] + x[k - 2]).norm() / 1e-3);
      }
      CHECK(fastest <= speed * (1 + 1e-9));
      CHECK(fastest > 0.9 * speed);
      CHECK(travel > 0.6 * speed * 20);
      CHECK(jerk < 0.35 * speed);  // no corner is taken at full speed within one frame
    }
  }
}

TEST_CASE("amplitude is the farthest point of a path's shape") {
  for (const std::string name : {"press", "circle", "tour"}) {
    const auto device = make_device("path:" + name + ",amplitude=0.02", context);
    double farthest = 0;
    for (const Vec3& x : motion(*device, 30)) farthest = std::max(farthest, x.norm());
    CHECK(farthest <= 0.02 + 1e-12);
    CHECK(farthest > 0.015);  // corners are rounded
  }
}

TEST_CASE("the tour presses in, leaves the box and returns") {
  const auto x = motion(*make_device("path:tour", context), 10);
  double depth = 0;
  std::size_t outside = 0, longest = 0, run = 0;
  for (const Vec3& q : x) {
    depth = std::max(depth, q.dot(context.inward));
    run = context.box.contains(q) ? 0 : run + 1;
    outside += run > 0;
    longest = std::max(longest, run);
  }
  CHECK(depth > 0.015);
  CHECK(longest > 50);
  CHECK(outside < x.size() / 4);
  CHECK(context.box.contains(x.back()));
}

TEST_CASE("tremor and noise have the asked root mean square and are seeded") {
  const auto calm = motion(*make_device("path:circle", context), 20);
  for (const std::string kind : {"tremor", "noise"}) {
    const auto shaken = motion(*make_device("path:circle," + kind + "=0.0002", context), 20);
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 1000; k < calm.size(); ++k) sum += (shaken[k] - calm[k]).cwiseAbs2();
    const Vec3 rms = (sum / static_cast<double>(calm.size() - 1000)).cwiseSqrt();
    for (int i = 0; i < 3; ++i) CHECK(rms[i] == Approx(0.0002).epsilon(0.1));
    CHECK(shaken.front() == Vec3::Zero());
    CHECK(shaken == motion(*make_device("path:circle," + kind + "=0.0002", context), 20));
    DeviceContext other = context;
    other.seed = 4;
    CHECK(shaken != motion(*make_device("path:circle," + kind + "=0.0002", other), 20));
  }
}

TEST_CASE("a trace is interpolated through its rows and held after its end") {
  const test::TemporaryFolder folder;
  write(folder / "a.csv", "t,x,y,z\n5,0,0,0\n5.5,0.001,0,0\n6,0.002,0.001,0\n6.5,0.002,0.003,0.001\n");
  DeviceContext where = context;
  where.folder = folder.path();
  const auto device = make_device("trace:a.csv,scale=2,offset=0.01/0/-0.01", where);
  const Vec3 offset(0.01, 0, -0.01);
  CHECK(device->duration() == 1.5);
  CHECK(device->position(0, {}) == offset);
  CHECK((device->position(0.5, {}) - offset - Vec3(0.002, 0, 0)).norm() < 1e-15);
  CHECK((device->position(1.0, {}) - offset - Vec3(0.004, 0.002, 0)).norm() < 1e-15);
  CHECK((device->position(1.5, {}) - offset - Vec3(0.004, 0.006, 0.002)).norm() < 1e-15);
  CHECK(device->position(9, {}) == device->position(1.5, {}));
  const Vec3 between = device->position(0.25, {}) - offset;
  CHECK(between.x() > 0.0);
  CHECK(between.x() < 0.002);
}

TEST_CASE("bad traces name file and line") {
  const test::TemporaryFolder folder;
  DeviceContext where = context;
  where.folder = folder.path();
  const std::vector<std::pair<std::string, std::string>> cases{
      {"t,x,y,z\n0,0,0,0\n1,nan,0,0\n", "bad.csv:3"},
      {"t,x,y,z\n0,0,0,0\n1,0,0\n", "bad.csv:3"},
      {"t,x,y,z\n0,0,0,0\n1,0,0,0\n0.5,0,0,0\n", "bad.csv:4"},
      {"t,x,y,z\n0,0,0,inf\n", "bad.csv:2"},
      {"t,x,y,z\n0,0,zero,0\n", "bad.csv:2"},
      {"t,x,y\n0,0,0\n", "bad.csv:1"},
      {"t,x,y,z\n", "bad.csv: "},
      {"", "bad.csv: "},
      {"t,x,y,z\n0,0,0,0\n1,1e999,0,0\n", "bad.csv:3"}};
  for (const auto& [text, expected] : cases) {
    CAPTURE(text);
    write(folder / "bad.csv", text);
    CHECK_THAT(message("trace:bad.csv", where), Catch::Contains(expected));
  }
  CHECK_THAT(message("trace:missing.csv", where), Catch::Contains("missing.csv"));
}

TEST_CASE("unknown devices are refused in one line") {
  for (const std::string spec :
       {"path", "path:", "path:spiral", "path:press,speed=fast", "path:press,speed=-1", "path:press,speed=0",
        "path:press,speed=nan", "path:press,speed=1e9", "path:press,amplitude=1e9",
        "path:press,speed=1,speed=2", "path:press,colour=red", "path:press,speed", "hand:thumb", "",
        "trace:", "mouse:left"}) {
    CAPTURE(spec);
    const std::string text = message(spec);
    CHECK_FALSE(text.empty());
    CHECK(text.find('\n') == std::string::npos);
  }
  CHECK_THAT(message("path:spiral"), Catch::Contains("press"));
}

TEST_CASE("a hand obeys its equation of motion: exact solutions with a held force and against a spring") {
  const auto hand =
      make_hand_device(*find_hand_profile("omega"), make_trace_device({0, 1}, {Vec3::Zero(), Vec3::Zero()}),
                       {.grip = 200, .mass = 0.1, .damping_ratio = 0.5});
  const Vec3 force(0.3, -0.1, 0);
  const double omega = std::sqrt(200 / 0.1), damped = omega * std::sqrt(0.75);
  CHECK(hand->answers_force());
  for (int k = 0; k <= 400; ++k) {
    const double t = k * 1e-3;
    const Vec3 x = hand->position(t, force);
    // Step response of a damped oscillator.
    const double share =
        1 - std::exp(-0.5 * omega * t) * (std::cos(damped * t) + 0.5 * omega / damped * std::sin(damped * t));
    CHECK((x - share * force / 200).norm() <= 1e-5);  // the encoder's steps
  }
  CHECK(hand->position(0, force) == Vec3::Zero());  // an earlier time starts anew
}

TEST_CASE("a hand that follows a line ends where grip and body balance, and behind its target in between") {
  const double grip = 300, body = 200;
  const auto hand = make_hand_device(
      *find_hand_profile("touch"),
      make_trace_device({0, 1, 3}, {Vec3::Zero(), Vec3(0.02, 0, 0), Vec3(0.02, 0, 0)}), {.grip = grip});
  Vec3 x = Vec3::Zero();
  for (int k = 0; k <= 3000; ++k) {
    x = hand->position(k * 1e-3, -body * x);
    REQUIRE(x.allFinite());
    if (k == 900) CHECK(x[0] < 0.018);
  }
  CHECK(x[0] == Approx(0.02 * grip / (grip + body)).margin(6e-5));
  CHECK(x.tail<2>().norm() == 0);
}

TEST_CASE("hands: profiles, grips and settings, and what is wrong with others") {
  for (const std::string& profile : hand_profile_names()) {
    CAPTURE(profile);
    const auto free = make_device("hand:" + profile + ",target=circle,speed=0.05,grip=firm", context);
    const auto path = make_device("path:circle,speed=0.05", context);
    double apart = 0;
    for (int k = 0; k < 3000; ++k) {
      const Vec3 target = path->position(k * 1e-3, Vec3::Zero()), x = free->position(k * 1e-3, Vec3::Zero());
      apart = std::max(apart, (x - target).norm());
    }
    CHECK(apart > 0);
    CHECK(apart < 1.5e-3);  // a free hand follows closely
    CHECK(free->limits().force == find_hand_profile(profile)->force_limit);
  }
  CHECK(message("hand:touch").empty());
  CHECK(message("hand:premium,grip=450,tremor=0.0001,noise=1e-5,amplitude=0.01").empty());
  CHECK(message("hand:glove").find("expected one of touch, premium, omega, falcon") != std::string::npos);
  CHECK(message("hand:touch,grip=strong").find("light, medium, firm") != std::string::npos);
  CHECK(message("hand:touch,grip=0").find("at least 1") != std::string::npos);
  CHECK(message("hand:touch,target=nowhere").find("unknown path 'nowhere'") != std::string::npos);
  CHECK(message("hand:touch,weight=3").find("unknown setting 'weight'") != std::string::npos);
  CHECK(message("hand:").find("expected a name") != std::string::npos);
}
