#include "run_logs.hpp"
#include "scheduling/record/run_files.hpp"
#include "scheduling/session/session.hpp"
#include "small_body.hpp"

TEST_CASE("times that cannot be and a box without room are refused, naming the row or the key") {
  const TemporaryFolder folder;
  const auto refused = [&](const char* name, const std::string& rows, bool arrivals) {
    std::ofstream(folder / name) << "t,x,y,z\n" << rows;
    SessionOptions options = virtual_options(0.1);
    if (arrivals)
      options.planning.arrivals = folder / name;
    else
      options.motion.device = TraceMotion{.file = folder / name};
    return error_of([&] { make_plan(small_input(), options); });
  };
  CHECK_THAT(refused("twice.csv", "0,0,0,0\n0.1,0,0,-0.001\n0.1,0,0,-0.002\n", false),
             Contains("twice.csv:4: a second row at 0.1 s"));
  CHECK(refused("good.csv", "0,0,0,0\n0.1,0,0,-0.001\n0.2,0,0,-0.002\n", false).empty());
  CHECK_THAT(refused("late.csv", "0,0,0,0\n1e300,0,0,-0.006\n", true), Contains("late.csv:3", "86400"));
  CHECK(refused("same.csv", "1,0,0,0\n1,0,0,-0.006\n", true).empty());  // states may come together
  SessionInput point = small_input();
  point.touched.space.box = {Vec3::Zero(), Vec3::Zero()};
  CHECK_THROWS_WITH(make_plan(point, virtual_options(0.1)), Contains("state_space.box", "room"));
}

TEST_CASE("a body that cannot be solved is refused before the session begins, naming what is wrong") {
  const auto refused = [&](auto change) {
    SessionInput input = small_input();
    auto body = std::make_shared<Body>(*input.touched.body);
    change(*body);
    input.touched.body = body;
    return error_of([&] { make_plan(input, virtual_options(0.1)); });
  };
  CHECK_THAT(refused([](Body& b) { b.clamp.clear(); }), Contains("clamp"));
  CHECK_THAT(refused([](Body& b) { b.contact = b.clamp; }), Contains("contact"));
  CHECK_THAT(refused([](Body& b) { b.material.poisson = 0.5; }), Contains("poisson"));
  CHECK_THAT(refused([](Body& b) { b.material.young = -1; }), Contains("young"));
  CHECK(refused([](Body&) {}).empty());
}

TEST_CASE("the frame of the switch is that of the session's clock") {
  SessionOptions options = virtual_options(0.1);
  options.clock.frame = 0.002;
  CHECK(make_plan(small_input(), options).render.switching.frame == 0.002);
}

TEST_CASE("bad sessions are refused before anything is solved or written") {
  const TemporaryFolder folder;
  const auto refuse = [&](auto change) {
    SessionOptions options = virtual_options(0.1);
    change(options);
    SessionInput input = small_input();
    input.files.states = folder / "none.states";
    CHECK_THROWS_AS(make_plan(input, options), InputError);
    CHECK_THROWS_AS(run_session(input, options), InputError);
    CHECK_FALSE(fs::exists(folder / "none.states"));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuse([](SessionOptions& o) { o.planning.policy = "best"; });
  refuse([](SessionOptions& o) { o.workers.count = 0; });
  refuse([](SessionOptions& o) { o.switching.jnd_share = -1; });
  refuse([nan](SessionOptions& o) { o.switching.jnd_floor = nan; });
  refuse([](SessionOptions& o) { o.switching.paper_interval = 0; });
  refuse([](SessionOptions& o) { o.clock.seconds = -1; });
  refuse([](SessionOptions& o) { o.clock.seconds = 0; });
  refuse([nan](SessionOptions& o) { o.clock.seconds = nan; });
  refuse([nan](SessionOptions& o) { o.workers.latency = nan; });
  refuse([](SessionOptions& o) { o.motion.device = TraceMotion{.file = "nowhere.csv"}; });
  refuse([](SessionOptions& o) { o.motion.device = Registered("spiral"); });
  refuse([](SessionOptions& o) { o.workers.cost = Registered("free"); });
  refuse([](SessionOptions& o) { o.motion.predictor = "oracle"; });
  refuse([&](SessionOptions& o) { o.motion.replay = folder / "no run"; });
  refuse([&](SessionOptions& o) {
    std::ofstream(folder / "back.csv") << "t,x,y,z\n-1,0,0,0\n";
    o.planning.arrivals = folder / "back.csv";
  });
  std::ofstream(folder / "file") << "not a folder";
  CHECK_THROWS_AS(prepare_run_folder(folder / "file"), InputError);
  CHECK_THROWS_AS(prepare_run_folder("/proc/forefeel"), InputError);
}

TEST_CASE(
    "cost and latency of simulated workers are said to be ignored under the real clock, and only there") {
  const auto says_so = [](const SessionOptions& options) {
    const SessionResult r = run_session(small_input(), options);
    return std::ranges::any_of(r.notes, [](const std::string& note) {
      return note.find("ignored under the real clock") != std::string::npos;
    });
  };
  SessionOptions options = virtual_options(0.05);
  options.workers.cost = ConstantCost{0.5};
  options.workers.latency = 0.01;
  CHECK_FALSE(says_so(options));
  options.clock.kind = Clock::real;
  CHECK(says_so(options));
  options.workers.cost = CostSpec();
  CHECK(says_so(options));  // the latency
  options.workers.latency = 0;
  CHECK_FALSE(says_so(options));
}
