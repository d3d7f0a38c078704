#include "scheduling/motion/device.hpp"
#include "scheduling/motion/hand_device.hpp"
#include "scheduling/motion/trace.hpp"
#include "small_body.hpp"

namespace {

const FactoryContext context{.box = {Vec3(-0.036, -0.036, -0.036), Vec3(0.036, 0.036, 0.024)},
                             .inward = Vec3(0.1, 0.2, -1).normalized(),
                             .seed = 3,
                             .folder = {}};

std::vector<Vec3> motion(Device& device, double seconds, double step = 1e-3) {
  std::vector<Vec3> x;
  for (std::size_t k = 0; static_cast<double>(k) * step <= seconds; ++k)
    x.push_back(device.position(static_cast<double>(k) * step, Vec3::Zero()));
  return x;
}

std::string message(const DeviceSpec& device, const FactoryContext& where = context) {
  return error_of([&] { make_device(device, where); });
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

}  // namespace

TEST_CASE("every path starts at rest, keeps to its speed and is smooth") {
  for (std::size_t i = 0; i < path_names().size(); ++i) {
    CAPTURE(path_names()[i]);
    for (const double speed : {0.02, 0.06}) {
      const auto device = make_device(PathMotion{.path = static_cast<PathName>(i), .speed = speed}, context);
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
  for (const PathName path : {PathName::press, PathName::circle, PathName::tour}) {
    const auto device = make_device(PathMotion{.path = path, .amplitude = 0.02}, context);
    double farthest = 0;
    for (const Vec3& x : motion(*device, 30)) farthest = std::max(farthest, x.norm());
    CHECK(farthest <= 0.02 + 1e-12);
    CHECK(farthest > 0.015);  // corners are rounded
  }
}

TEST_CASE("the tour presses in, leaves the box and returns") {
  const auto x = motion(*make_device(PathMotion{.path = PathName::tour}, context), 10);
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
  const PathMotion circle{.path = PathName::circle};
  const auto calm = motion(*make_device(circle, context), 20);
  for (double PathMotion::*kind : {&PathMotion::tremor, &PathMotion::noise}) {
    PathMotion disturbed = circle;
    disturbed.*kind = 0.0002;
    const auto shaken = motion(*make_device(disturbed, context), 20);
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 1000; k < calm.size(); ++k) sum += (shaken[k] - calm[k]).cwiseAbs2();
    const Vec3 rms = (sum / static_cast<double>(calm.size() - 1000)).cwiseSqrt();
    for (int i = 0; i < 3; ++i) CHECK(rms[i] == Approx(0.0002).epsilon(0.1));
    CHECK(shaken.front() == Vec3::Zero());
    CHECK(shaken == motion(*make_device(disturbed, context), 20));
    FactoryContext other = context;
    other.seed = 4;
    CHECK(shaken != motion(*make_device(disturbed, other), 20));
  }
}

TEST_CASE("a path with pauses is the path without them, at rest at its turns") {
  const PathMotion reach{.path = PathName::reach, .speed = 0.06, .amplitude = 0.03};
  PathMotion paused = reach;
  paused.pause = 0.3;
  const auto x = motion(*make_device(paused, context), 12);
  std::vector<Vec3> rests;
  std::vector<std::size_t> lengths;  // [ms]
  for (std::size_t k = 1; k < x.size(); ++k) {
    if ((x[k] - x[k - 1]).norm() > 1e-9) continue;
    if (rests.empty() || (x[k] - rests.back()).norm() > 1e-6) rests.push_back(x[k]), lengths.push_back(0);
    ++lengths.back();
  }
  REQUIRE(rests.size() >= 5);
  for (std::size_t i = 0; i + 1 < rests.size(); ++i) {
    CHECK(lengths[i] >= 298);
    CHECK(lengths[i] <= 325);
    CHECK((rests[i + 1] - rests[i]).norm() > 0.005);
  }
  // Each place of a rest is a corner, which the path without pauses rounds; the speed is kept.
  const auto moving = motion(*make_device(reach, context), 12);
  for (const Vec3& at : rests) {
    double nearest = 1;
    for (const Vec3& q : moving) nearest = std::min(nearest, (q - at).norm());
    CHECK(nearest < 0.0051);  // half a window
  }
  for (std::size_t k = 1; k < x.size(); ++k) CHECK((x[k] - x[k - 1]).norm() <= 0.06e-3 * (1 + 1e-9));
  const PathMotion round{.path = PathName::circle};
  PathMotion still = round;
  still.pause = 0.3;
  // The lead turns twice, in the middle and at the rim; the circle itself never rests.
  const auto after = motion(*make_device(still, context), 12);
  const auto resting = std::count_if(after.begin() + 1, after.end(),
                                     [](const Vec3& q) { return (q - *(&q - 1)).norm() <= 1e-9; });
  CHECK(resting >= 596);
  CHECK(resting <= 650);
}

TEST_CASE("a trace is interpolated through its rows and held after its end") {
  const TemporaryFolder folder;
  write(folder / "a.csv", "t,x,y,z\n5,0,0,0\n5.5,0.001,0,0\n6,0.002,0.001,0\n6.5,0.002,0.003,0.001\n");
  FactoryContext where = context;
  where.folder = folder.path();
  const auto device =
      make_device(TraceMotion{.file = "a.csv", .scale = 2, .offset = Vec3(0.01, 0, -0.01)}, where);
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
  const TemporaryFolder folder;
  FactoryContext where = context;
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
    CHECK_THAT(message(TraceMotion{.file = "bad.csv"}, where), Contains(expected));
  }
  CHECK_THAT(message(TraceMotion{.file = "missing.csv"}, where), Contains("missing.csv"));
}

TEST_CASE("devices outside their ranges are refused") {
  const PathMotion press;
  const auto path = [&](double PathMotion::*member, double value) {
    PathMotion motion = press;
    motion.*member = value;
    return motion;
  };
  CHECK(message(press).empty());
  CHECK_THAT(message(PathMotion{.speed = 0}), Contains("speed is '0', expected a number of at least"));
  CHECK_THAT(message(PathMotion{.speed = 1e9}), Contains("speed is 1e+09, expected at most 1000 m/s"));
  CHECK_THAT(message(PathMotion{.speed = std::nan("")}), Contains("device path:press,speed=nan: "));
  CHECK_THAT(message(path(&PathMotion::amplitude, 1e9)), Contains("at most 10 m"));
  CHECK_THAT(message(path(&PathMotion::tremor, -1)), Contains("tremor is '-1'"));
  CHECK_THAT(message(path(&PathMotion::pause, 61)), Contains("pause is 61, expected at most 60 s"));
  CHECK_THAT(message(path(&PathMotion::noise, 2)), Contains("noise is 2, expected at most 1 m"));
  CHECK_THAT(message(HandMotion{.grip = 0}), Contains("at least 1"));
  CHECK_THAT(message(HandMotion{.target = {.speed = -1}}), Contains("speed is '-1'"));
  CHECK_THAT(message(TraceMotion{.file = "a.csv", .scale = std::nan("")}), Contains("scale is 'nan'"));
}

TEST_CASE("a device prints as it is written on the command line") {
  CHECK(to_text(DeviceSpec()) == "path:press,speed=0.06");
  CHECK(to_text(DeviceSpec(PathMotion{.path = PathName::raster})) == "path:raster");
  CHECK(to_text(
            DeviceSpec(PathMotion{.path = PathName::line, .speed = 0.1, .amplitude = 0.02, .noise = 1e-5})) ==
        "path:line,speed=0.1,amplitude=0.02,noise=1e-05");
  CHECK(to_text(DeviceSpec(TraceMotion{.file = "a/b.csv", .scale = 2, .offset = Vec3(0.01, 0, -1)})) ==
        "trace:a/b.csv,scale=2,offset=0.01/0/-1");
  CHECK(to_text(DeviceSpec(HandMotion{.profile = HandName::omega})) == "hand:omega,target=press,grip=300");
  CHECK(to_text(DeviceSpec(Registered("mine", {{"", "a.csv"}, {"gain", "2"}}))) == "mine:a.csv,gain=2");
  CHECK(to_text(DeviceSpec(PathMotion{.speed = 0.06}, "path:press,speed=0.060")) == "path:press,speed=0.060");
}

TEST_CASE("a hand obeys its equation of motion: exact solutions with a held force and against a spring") {
  const auto hand =
      make_hand_device(profile_of(HandName::omega), make_trace_device({{0, 1}, {Vec3::Zero(), Vec3::Zero()}}),
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
      profile_of(HandName::touch),
      make_trace_device({{0, 1, 3}, {Vec3::Zero(), Vec3(0.02, 0, 0), Vec3(0.02, 0, 0)}}), {.grip = grip});
  Vec3 x = Vec3::Zero();
  for (int k = 0; k <= 3000; ++k) {
    x = hand->position(k * 1e-3, -body * x);
    REQUIRE(x.allFinite());
    if (k == 900) CHECK(x[0] < 0.018);
  }
  CHECK(x[0] == Approx(0.02 * grip / (grip + body)).margin(6e-5));
  CHECK(x.tail<2>().norm() == 0);
}

TEST_CASE("a free hand of every profile follows its path closely") {
  for (const HandName profile : {HandName::touch, HandName::premium, HandName::omega, HandName::falcon}) {
    CAPTURE(name(profile));
    const PathMotion circle{.path = PathName::circle, .speed = 0.05};
    const auto free = make_device(HandMotion{.profile = profile, .target = circle, .grip = 800}, context);
    const auto path = make_device(circle, context);
    double apart = 0;
    for (int k = 0; k < 3000; ++k) {
      const Vec3 target = path->position(k * 1e-3, Vec3::Zero()), x = free->position(k * 1e-3, Vec3::Zero());
      apart = std::max(apart, (x - target).norm());
    }
    CHECK(apart > 0);
    CHECK(apart < 1.5e-3);
    CHECK(free->limits().force == profile_of(profile).force_limit);
  }
}
