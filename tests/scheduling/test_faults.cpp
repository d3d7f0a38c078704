// Faults around the loop: workers that fail, a planner that stands still, states that are wrong, a device that jumps
// or gives no number, a clock that steps. The loop runs on, what the device gets stays inside the limits of force and
// slew by the wall clock, and each fault is counted and said.

#include <mutex>

#include "approx/model/updater.hpp"
#include "run_logs.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "scheduling/render/loop_thread.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/worker_threads.hpp"
#include "sent_limits.hpp"
#include "small_body.hpp"

namespace {

const double no_number = std::numeric_limits<double>::quiet_NaN();

SessionOptions real_options(double seconds) {
  SessionOptions options = virtual_options(seconds);
  options.clock.kind = Clock::real;
  return options;
}

// Threads of the program behind a wall: their clock may throw, and their results may be changed on the way.
struct FaultyWorkers : RealWorkers {
  explicit FaultyWorkers(const SessionInput& input)
      : threads(input.touched.body, {.spacing = input.touched.space.spacing}) {}
  virtual double clock(double t) { return t; }
  virtual void change(State&) {}

  void begin(std::function<double()> now) override {
    threads.begin([this, now] {
      std::this_thread::sleep_for(std::chrono::milliseconds(3));  // so that work is left on fast machines
      return clock(now());
    });
  }
  bool serves() const override { return true; }
  void serve() override { threads.serve(); }
  void stop() override { threads.stop(); }
  int workers() const override { return threads.workers(); }
  bool takes_jobs(int worker) const override { return threads.takes_jobs(worker); }
  void dispatch(int worker, Job job) override { threads.dispatch(worker, std::move(job)); }
  void cancel(int worker) override { threads.cancel(worker); }
  void collect(std::vector<JobResult>& out, double timeout) override {
    threads.collect(out, timeout);
    for (JobResult& result : out)
      if (result.state.usable()) change(result.state);
  }
  std::exception_ptr failure() const override { return threads.failure(); }
  int lost() const override { return threads.lost(); }
  std::vector<std::string> notes() const override { return threads.notes(); }

  WorkerThreads threads;
};

// The first `deaths` threads that look at the clock after `after` seconds die of it.
struct DyingWorkers final : FaultyWorkers {
  DyingWorkers(const SessionInput& input, std::size_t deaths, double after)
      : FaultyWorkers(input), most(deaths), from(after) {}
  double clock(double t) override {
    const std::lock_guard lock(mutex);
    if (t > from && dead.size() < most && dead.insert(std::this_thread::get_id()).second)
      throw std::runtime_error("hardware is gone");
    return t;
  }
  std::size_t most;
  double from;  // [s]
  std::mutex mutex;
  std::set<std::thread::id> dead;
};

// Changes the states whose number, from 0, is among those asked for.
struct LyingWorkers final : FaultyWorkers {
  LyingWorkers(const SessionInput& input, std::function<bool(int)> which, double times)
      : FaultyWorkers(input), lies(std::move(which)), factor(times) {}
  void change(State& state) override {
    if (!lies(count++)) return;
    state.force *= factor;
    state.stiffness *= factor;
    ++told;
  }
  std::function<bool(int)> lies;
  double factor;
  int count = 0, told = 0;
};

bool says(const std::vector<std::string>& lines, const std::string& word) {
  return std::ranges::any_of(lines,
                             [&](const std::string& line) { return line.find(word) != std::string::npos; });
}

// The run went to its end, within its limits.
SessionSummary check_whole(const SessionResult& result, const SessionInput& input,
                           const SessionOptions& options) {
  CHECK(result.run.end == RunEnd::whole);
  CHECK(result.frames.size() + result.loop.skipped >=
        static_cast<std::size_t>(options.clock.seconds / options.clock.frame));
  check_sent(result, options.safety);
  return summarise(result, input, options);
}

}  // namespace

TEST_CASE(
    "a worker that dies is lost and counted, the others go on; without any the loop renders what is known",
    SLOW("runs five sessions in real time")) {
  for (const std::size_t deaths : {1, 2}) {
    CAPTURE(deaths);
    SessionInput input = small_input();
    input.touched.space.spacing = 0.002;  // more states than there is time for
    SessionOptions options = real_options(4);
    options.workers.count = 2;
    const auto workers = std::make_shared<DyingWorkers>(input, deaths, 0.5);
    input.parts.workers = workers;
    const SessionResult result = run_session(input, options);
    const SessionSummary summary = check_whole(result, input, options);
    CHECK(summary.loop.faults.workers_lost == deaths);
    CHECK(says(attention(summary), deaths == 1 ? "1 worker was lost" : "2 workers were lost"));
    CHECK(says(result.notes, "a worker failed: hardware is gone"));
    const auto after = std::ranges::count_if(result.dispatch, [](const DispatchRecord& d) {
      return d.status == DispatchStatus::solved && d.finished > 1;
    });
    CHECK((after > 0) == (deaths == 1));
    CHECK(result.counts.solved > 0);
    if (deaths == 1) CHECK(result.failures.empty());
    if (deaths == 1) continue;
    REQUIRE(result.failures.size() == 1);
    CHECK(result.failures[0] == "the workers failed: hardware is gone; nothing more was solved");
  }
}

TEST_CASE(
    "a planner that stands still for two seconds: the force fades out and comes back, and it is counted",
    SLOW("waits for a planner that stands still")) {
  struct Sleeper final : Policy {
    std::string_view name() const override { return "sleeper"; }
    double priority(const Candidate& candidate, const PlannerView& view) const override {
      if (view.now > 0.4 && !slept.exchange(true)) std::this_thread::sleep_for(std::chrono::seconds(2));
      return 1 / (1e-3 + (candidate.at - view.hip.at).norm());
    }
    mutable std::atomic<bool> slept{false};
  };
  SessionInput input = small_input();
  input.touched.space.spacing = 0.002;
  input.parts.policy = std::make_shared<Sleeper>();
  input.parts.workers = std::make_shared<FaultyWorkers>(input);
  const SessionOptions options = real_options(7);
  const SessionResult result = run_session(input, options);
  const SessionSummary summary = check_whole(result, input, options);
  CHECK(summary.loop.faults.planner_stalls >= 1);
  CHECK(summary.loop.planner_stall >= 1.9);
  CHECK(summary.safety.stale + result.loop.skipped >= 1000);  // of 1.5 s
  CHECK(says(attention(summary), "the planner stood still until the force faded out"));
  // Faded out at the end of the stall; frames come back later.
  double within = 1, later = 0;
  for (const FrameRecord& f : result.frames) {
    if (f.t > 1.5 && f.t < 2.2) within = std::min(within, f.sent.norm());
    if (f.t > 3 && f.t < 6.9) later = std::max(later, f.sent.norm());
  }
  CHECK(within == 0);
  CHECK(later > 0);
}

TEST_CASE("states that are no numbers or 1000 times too strong are set aside, the first one too") {
  const auto third = [](int k) { return k % 3 == 2; };
  const auto first = [](int k) { return k == 0; };
  struct Lie {
    bool only_first;
    double factor;
  };
  for (const auto& [only_first, factor] :
       {Lie{false, no_number}, Lie{false, 1000}, Lie{true, no_number}, Lie{true, 1000}}) {
    const std::function<bool(int)> which = only_first ? std::function<bool(int)>(first) : third;
    CAPTURE(only_first, factor);
    SessionInput input = small_input();
    SessionOptions options = real_options(1);
    const auto workers = std::make_shared<LyingWorkers>(input, which, factor);
    input.parts.workers = workers;
    const SessionResult result = run_session(input, options);
    const SessionSummary summary = check_whole(result, input, options);
    REQUIRE(workers->told > 0);
    CHECK(summary.loop.faults.states_set_aside == static_cast<std::size_t>(workers->told));
    CHECK(summary.states.failed >= summary.loop.faults.states_set_aside);
    CHECK(says(attention(summary), "set aside: not a number, or far too strong"));
    double stiffest = 0;
    for (const State& state : result.states) stiffest = std::max(stiffest, state.stiffness.norm());
    const State truth = run_session(small_input(), virtual_options(0.1)).states.front();
    CHECK(stiffest < 30 * truth.stiffness.norm());
    CHECK(result.counts.solved > 3);
  }
}

namespace {

// A slow circle, but for some frames.
struct FaultyDevice final : Device {
  Vec3 position(double t, const Vec3&) noexcept override {
    const auto k = std::llround(1e3 * t);
    const Vec3 circle = 0.008 * Vec3(std::cos(3 * t) - 1, std::sin(3 * t), 0);
    if (k % 100 == 43 || k % 100 == 44) return {no_number, 0, std::numeric_limits<double>::infinity()};
    if (k % 200 >= 151 && k % 200 < 155) return circle + Vec3(0.03, 0.04, 0);  // 5 cm, for 4 ms
    return circle;
  }
  double duration() const override { return std::numeric_limits<double>::infinity(); }
};

}  // namespace

TEST_CASE("a device that jumps by 5 cm or gives no number is held, counted and said, under both clocks") {
  for (const Clock clock : {Clock::virtual_time, Clock::real}) {
    CAPTURE(static_cast<int>(clock));
    SessionInput input = small_input();
    input.parts.device = std::make_shared<FaultyDevice>();
    SessionOptions options = virtual_options(1.2);
    options.clock.kind = clock;
    const SessionResult result = run_session(input, options);
    const SessionSummary summary = check_whole(result, input, options);
    const SessionSummary::Faults& faults = summary.loop.faults;
    CHECK(std::ranges::all_of(result.frames, [](const FrameRecord& f) { return f.at.allFinite(); }));
    if (result.loop.skipped == 0) {
      CHECK(faults.device_held == 24);
      CHECK(faults.device_jumps == 12);  // there and back
    }
    CHECK(faults.device_held > 0);
    CHECK(faults.device_jumps > 0);
    CHECK(says(attention(summary), "without a finite position of the device: the last one was held"));
    CHECK(says(attention(summary), "with a jump of the device"));
  }
}

TEST_CASE("a session without faults counts none, and help declares what is counted") {
  const SessionOptions options = virtual_options(0.5);
  const SessionSummary summary = summarise(run_session(small_input(), options), small_input(), options);
  const SessionSummary::Faults& faults = summary.loop.faults;
  CHECK(faults.states_set_aside + faults.workers_lost + faults.planner_stalls + faults.clock_steps +
            faults.device_held + faults.device_jumps ==
        0);
  for (const char* key : {"faults.states_set_aside", "faults.workers_lost", "faults.planner_stalls",
                          "faults.clock_steps", "faults.device_held", "faults.device_jumps"})
    CHECK(std::ranges::count(declared_columns(summary_columns({})), key, &Declared::name) == 1);
}

TEST_CASE("steps of the clock of the day are counted, its slow drift is not") {
  ClockWatch watch;
  std::int64_t steady = 5'000'000'000, of_day = 1'700'000'000'000'000'000;
  const auto pass = [&](std::int64_t steady_ns, std::int64_t day_ns) {
    watch.look(steady += steady_ns, of_day += day_ns);
  };
  for (int i = 0; i < 20'000; ++i) pass(500'000, 500'250);  // 500 ppm, the fastest that NTP slews
  CHECK(watch.steps() == 0);
  pass(500'000, 3'600'000'000'000);  // an hour ahead
  CHECK(watch.steps() == 1);
  pass(500'000, 500'000);
  CHECK(watch.steps() == 1);
  pass(500'000, -3'600'000'000'000);
  CHECK(watch.steps() == 2);
  pass(2'000'000'000, 2'000'000'000);  // a pause is no step
  CHECK(watch.steps() == 2);
}

TEST_CASE("a clock that goes backwards or leaps changes the force by no more than a frame may") {
  struct Shaking final : Device {
    Vec3 position(double t, const Vec3&) noexcept override { return {0.01 * std::sin(80 * t), 0, 0}; }
    double duration() const override { return std::numeric_limits<double>::infinity(); }
  } device;
  State rest;
  rest.force = Vec3::Zero();
  rest.stiffness = 800 * Mat3::Identity();
  const Model spring =
      fit_model(std::vector<State>{rest}, {.data = Data::force_and_stiffness, .length = 1}, Vec3::Zero());
  RenderOptions options;
  options.switching.rule = SwitchRule::none;
  options.safety.ramp_seconds = 0;
  LoopLink link;
  link.models.publish(&spring);
  double now = 0;
  RenderLoop loop(device, link, options, 1000, {.now = [&] { return now; }});
  for (std::size_t k = 0; k < 1000; ++k) {
    const double step = k == 300 ? -0.5 : k == 600 ? 3600 : 1e-3;
    const Vec3 before = loop.sent();
    now += step;
    link.planner_beat.store(now);
    loop.frame(k, now);
    CAPTURE(k);
    REQUIRE((loop.sent() - before).norm() <= 1 + 1e-9);
    if (k == 300) CHECK(loop.sent() == before);  // no time has passed
  }
  CHECK(loop.sent() == Vec3::Zero());
}

TEST_CASE("session, planner, loop and workers read steady clocks alone") {
  std::size_t files = 0;
  for (const char* folder : {"scheduling", "approx", "solver", "geometry"})
    for (const auto& entry : fs::recursive_directory_iterator(source_folder() / folder)) {
      const std::string ending = entry.path().extension().string();
      if (ending != ".cpp" && ending != ".hpp") continue;
      ++files;
      const std::string text = text_of(entry.path());
      CAPTURE(entry.path().string());
      for (const char* word : {"system_clock", "gettimeofday", "high_resolution_clock"})
        CHECK_THAT(text, !Contains(word));
      // real_run.cpp looks at it to count its steps
      if (entry.path().filename() != "real_run.cpp") CHECK_THAT(text, !Contains("CLOCK_REALTIME"));
    }
  CHECK(files > 200);
}
