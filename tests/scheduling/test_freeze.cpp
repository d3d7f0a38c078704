// Frames that come late, and the end of a session: the force that is sent changes no faster than the slew
// limit allows by the wall clock, and is zero at the end.

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "approx/model/updater.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/render/loop_thread.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/session.hpp"
#include "small_body.hpp"

namespace {

constexpr std::int64_t ms = 1'000'000;  // [ns]

// A force of 8 N that turns its direction every 40 ms.
class Oscillating final : public Device {
 public:
  Vec3 position(double t, const Vec3&) noexcept override {
    return {0.01 * std::sin(2 * M_PI * t / 0.08), 0, 0};
  }
  double duration() const override { return std::numeric_limits<double>::infinity(); }
};

Model spring() {
  State rest;
  rest.force = Vec3::Zero();
  rest.stiffness = 800 * Mat3::Identity();
  return fit_model(std::vector<State>{rest}, {.data = Data::force_and_stiffness, .length = 1}, Vec3::Zero());
}

// A loop with a clock that the test sets. It renders a stiff spring from the first frame on.
struct FakeRun {
  explicit FakeRun(std::size_t count, RenderOptions options = plain())
      : limits(options.safety),
        frames(count),
        pacer(options.frame, count),
        loop(device, link, options, count, {.now = [this] { return now; }, .spare = 100}) {
    link.models.publish(&model);
  }
  static RenderOptions plain() {
    RenderOptions options;
    options.switching.rule = SwitchRule::none;
    options.safety.ramp_seconds = 0;
    return options;
  }
  // A frame that wakes `late` after it is due, and sends `cost` after that [s].
  void frame(double late = 0, double beat_age = 0) {
    now = std::max(now, 1e-9 * static_cast<double>(pacer.due())) + late;
    link.planner_beat.store(now - beat_age);
    loop.frame(pacer.begin(std::llround(now * 1e9)), now);
    sent.push_back({now, loop.sent()});
  }
  double last_force() const { return loop.sent().norm(); }

  struct Sent {
    double t;
    Vec3 force;
  };
  SafetyOptions limits;
  std::size_t frames;
  FramePacer pacer;
  Oscillating device;
  LoopLink link;
  const Model model = spring();
  double now = 0;
  RenderLoop loop;
  std::vector<Sent> sent;
};

// Every pair of forces, by the wall clock.
template <class Sent>
void check_slew(const std::vector<Sent>& sent, double limit) {
  double worst = 0;
  for (std::size_t i = 0; i < sent.size(); ++i)
    for (std::size_t k = i + 1; k < std::min(sent.size(), i + 20); ++k)
      worst = std::max(worst, (sent[k].force - sent[i].force).norm() - limit * (sent[k].t - sent[i].t));
  CHECK(worst <= 1e-6);
}

}  // namespace

TEST_CASE("a loop that wakes late renders the newest frame and counts those that it skips") {
  FramePacer pacer(1e-3, 5000);
  CHECK(pacer.due() == 0);
  CHECK(pacer.begin(30 * ms) == 0);  // the first frame is never skipped
  CHECK(pacer.skipped() == 0);
  CHECK(pacer.longest_pause() == Approx(0.03));  // from the start of the session
  CHECK(pacer.paused_at() == 0);
  CHECK(pacer.begin(30 * ms + 10) == 30);
  CHECK(pacer.skipped() == 29);
  CHECK(pacer.due() == 31 * ms);
  CHECK(pacer.begin(31 * ms + 999'999) == 31);  // late, but the next one is not due
  CHECK(pacer.lateness() == 999'999);
  CHECK(pacer.begin(2031 * ms + 500'000) == 2031);
  CHECK(pacer.lateness() == 500'000);
  CHECK(pacer.skipped() == 29 + 1999);
  CHECK(pacer.longest_pause() == Approx(1.9995).margin(1e-6));
  CHECK(pacer.paused_at() == Approx(0.032).margin(1e-6));
  CHECK(pacer.due() == 2032 * ms);
  CHECK(pacer.begin(9000 * ms) == 4999);  // the last frame is always rendered
  CHECK(pacer.skipped() == 29 + 1999 + 4999 - 2032);
  CHECK(pacer.begin(9000 * ms) == 9000);  // of the ramp at the end: no frame of the session is skipped
  CHECK(pacer.skipped() == 29 + 1999 + 4999 - 2032);
}

TEST_CASE("frame times that are no whole nanoseconds never lead to a frame that is not due") {
  for (const double frame : {1e-3, 1.0 / 3000, 0.7e-3, 0.1}) {
    FramePacer pacer(frame, 1'000'000);
    std::int64_t now = 0;
    for (int i = 0; i < 2000; ++i) {
      now = std::max(now + 1, pacer.due() + (i % 7 == 3 ? 12'345'678 : i % 5));
      const std::size_t k = pacer.begin(now);
      if (i == 0) continue;
      CHECK(pacer.lateness() >= 0);
      CHECK(pacer.lateness() <= std::llround(frame * 1e9) + 1);
      CHECK(pacer.due() == std::llround(static_cast<double>(k + 1) * frame * 1e9));
    }
  }
}

TEST_CASE("after a pause of two seconds the force changes by one frame's limit, not by what it missed") {
  FakeRun run(5000);
  for (int i = 0; i < 500; ++i) run.frame();
  REQUIRE(run.last_force() < 8.1);
  const std::size_t before = run.sent.size();
  run.frame(2.0);
  CHECK(run.pacer.skipped() == 2000);
  CHECK((run.sent[before].force - run.sent[before - 1].force).norm() <= 1 + 1e-9);
  for (int i = 0; i < 500; ++i) run.frame();
  check_slew(run.sent, run.limits.slew_limit);
  CHECK(run.pacer.skipped() == 2000);  // no burst, and no more are lost
}

TEST_CASE("frames that come early or late change the force by the wall time between them") {
  FakeRun run(4000);
  for (int i = 0; i < 3000 && run.pacer.due() < 3900 * ms; ++i)
    run.frame(i % 3 == 0 ? 0.9e-3 : i % 11 == 5 ? 3.3e-3 : 0.1e-3 * (i % 4));
  CHECK(run.pacer.skipped() > 500);
  check_slew(run.sent, run.limits.slew_limit);
  // and no frame by more than an ordinary one may
  for (std::size_t k = 1; k < run.sent.size(); ++k)
    REQUIRE((run.sent[k].force - run.sent[k - 1].force).norm() <= 1 + 1e-9);
}

TEST_CASE("a planner that stood still is stale by the loop's clock, however late the loop is itself") {
  FakeRun run(5000);
  for (int i = 0; i < 100; ++i) run.frame();
  CHECK(run.loop.safety().counts().stale == 0);
  run.frame(2.0, 2.0);  // both stopped: the beat is as old as the pause
  CHECK(run.loop.safety().counts().stale == 1);
  run.frame();
  CHECK(run.loop.safety().counts().stale == 1);
}

TEST_CASE("the velocity after skipped frames is that of the motion, not the distance over one frame") {
  FakeRun run(5000);
  run.frame();
  run.frame();
  const Vec3 before = run.loop.hip().at;
  run.frame(0.010);
  const double passed = 0.010;
  CHECK((run.loop.hip().velocity - (run.loop.hip().at - before) / (passed + 0.001)).norm() < 1e-9);
}

TEST_CASE("a session ends with zero force, within the slew limit, however its frames come") {
  for (const double late : {0.0, 0.4e-3, 0.95e-3, 2.5e-3})
    for (const std::size_t frames : {1, 2, 5, 12, 13, 30, 230, 231, 240, 251}) {
      CAPTURE(late, frames);
      FakeRun run(frames);
      for (int i = 0; !run.loop.finished(); ++i) {
        REQUIRE(i < 2000);
        run.frame(i % 2 == 0 ? late : 0);
      }
      CHECK(run.last_force() == 0);
      check_slew(run.sent, run.limits.slew_limit);
      if (late == 0) CHECK(run.sent.size() == frames);  // the ramp is part of the session
      CHECK(run.loop.take_log().back().sent == Vec3::Zero());
    }
}

TEST_CASE("a session that is ended early takes the force to zero at the slew limit, and stops then") {
  FakeRun run(5000);
  for (int i = 0; i < 520 || run.last_force() < 7; ++i) run.frame();
  const std::size_t before = run.sent.size();
  run.loop.end();
  CHECK_FALSE(run.loop.finished());
  while (!run.loop.finished()) {
    const double last = run.last_force();
    run.frame();
    REQUIRE(run.last_force() <= last);
  }
  CHECK(run.last_force() == 0);
  CHECK(run.sent.size() - before == 8);  // 7 to 8 N at 1 N a frame
  check_slew(run.sent, run.limits.slew_limit);
  CHECK(run.loop.take_log().size() == run.sent.size());
}

TEST_CASE("virtual clock: runs end with zero force, whole ones and interrupted ones, in as many frames") {
  for (const bool hand : {false, true}) {
    CAPTURE(hand);
    SessionOptions options = virtual_options(0.7);
    const PathMotion press{.path = PathName::press, .speed = 0.06};
    options.motion.device =
        hand ? DeviceSpec(HandMotion{.profile = HandName::omega, .target = press}) : press;
    const SessionResult whole = run_session(small_input(), options);
    REQUIRE(whole.frames.size() == 700);
    CHECK_FALSE(whole.interrupted());
    CHECK(whole.frames.back().sent == Vec3::Zero());
    CHECK(whole.loop.ending_frames >= 1);
    CHECK(whole.loop.last_force == 0);
    CHECK(summarise(whole, small_input(), options).run.seconds == 0.7);

    std::atomic<bool> stop{false};
    options.stop.interrupted = &stop;
    const SessionResult cut = run_session(
        small_input(), options, {.progress = [&](const SessionProgress& p) { stop = stop || p.t > 0.2; }});
    CHECK(cut.interrupted());
    CHECK(cut.frames.size() < 700);
    CHECK(cut.frames.back().sent == Vec3::Zero());
    double most = 0;
    for (std::size_t k = 1; k < cut.frames.size(); ++k)
      most = std::max(most, (cut.frames[k].sent - cut.frames[k - 1].sent).norm());
    CHECK(most > 0);
    CHECK(most <= 1 + 1e-9);
  }
}

namespace {

// Stops this process for that long, as SIGSTOP from outside does.
void freeze(const std::string& seconds) {
  std::string command = "kill -STOP $PPID; sleep " + seconds + "; kill -CONT $PPID";
  char shell[] = "sh", option[] = "-c";
  char* arguments[] = {shell, option, command.data(), nullptr};
  pid_t child = 0;
  if (posix_spawn(&child, "/bin/sh", nullptr, nullptr, arguments, environ) != 0) return;
  int status = 0;
  waitpid(child, &status, 0);
}

struct Timed {
  double t;
  Vec3 force;
};

// Of a real run: its forces by the wall clock.
std::vector<Timed> timed(const SessionResult& result) {
  std::vector<Timed> sent;
  for (const FrameRecord& f : result.frames) sent.push_back({f.t + 1e-6 * f.timing.lateness_us, f.sent});
  return sent;
}

bool says(const SessionResult& result, const std::string& word) {
  return std::ranges::any_of(result.notes,
                             [&](const std::string& note) { return note.find(word) != std::string::npos; });
}

}  // namespace

TEST_CASE("real clock: a process that is stopped skips frames, keeps the slew limit and says so") {
  SessionOptions options = virtual_options(4);
  options.clock.kind = Clock::real;
  options.switching.rule = SwitchRule::none;
  SessionInput input = small_input();
  input.parts.device = std::make_shared<Oscillating>();
  bool frozen = false;
  const SessionResult result = run_session(input, options, {.progress = [&](const SessionProgress& p) {
                                             if (frozen || p.phase != SessionPhase::session || p.t < 0.15)
                                               return;
                                             frozen = true;
                                             freeze("0.7");
                                           }});
  REQUIRE(frozen);
  CHECK(result.loop.skipped >= 300);
  CHECK(result.loop.longest_pause >= 0.3);
  CHECK(result.loop.planner_stall >= 0.6);
  CHECK(says(result, "late and skipped"));
  CHECK(says(result, "the planner stood still"));
  CHECK(result.frames.size() + result.loop.skipped >= 4000);
  CHECK_FALSE(result.interrupted());
  CHECK(result.frames.back().sent == Vec3::Zero());
  check_slew(timed(result), options.safety.slew_limit);
  const SessionSummary summary = summarise(result, input, options);
  CHECK(summary.loop.skipped == result.loop.skipped);
  CHECK(summary.deadline.missed >= result.loop.skipped);
  CHECK(summary.run.seconds == 4);
  CHECK(summary.loop.faults.planner_stalls >= 1);
  CHECK(std::ranges::any_of(attention(summary), [](const std::string& line) {
    return line.starts_with("the loop stood still for ");
  }));
}

TEST_CASE(
    "real clock: a wish to end, and an exception in planning, take the force to zero and keep the run") {
  for (const bool fails : {false, true}) {
    CAPTURE(fails);
    SessionOptions options = virtual_options(60);
    options.clock.kind = Clock::real;
    std::atomic<bool> stop{false};
    options.stop.interrupted = &stop;
    SessionInput input = small_input();
    input.parts.device = std::make_shared<Oscillating>();
    const SessionResult result = run_session(input, options, {.progress = [&](const SessionProgress& p) {
                                               if (p.phase != SessionPhase::session || p.t < 0.3) return;
                                               if (fails) throw std::runtime_error("no more");
                                               stop = true;
                                             }});
    CHECK(result.interrupted());
    CHECK(result.frames.size() > 10);
    CHECK(result.frames.size() < 50000);
    CHECK(result.frames.back().sent == Vec3::Zero());
    CHECK(result.loop.last_force == 0);
    check_slew(timed(result), options.safety.slew_limit);
    CHECK(result.states.size() > 0);
    if (!fails) {
      CHECK(result.failures.empty());
      continue;
    }
    REQUIRE(result.failures.size() == 1);
    CHECK(result.failures[0] == "planning failed: no more; the session ended early");
  }
}
