#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <set>
#include <thread>

#include "geometry/common/error.hpp"
#include "run_logs.hpp"
#include "scheduling/record/run_files.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "scheduling/session/session_parts.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "small_body.hpp"
#include "solver/body/contact_stiffness.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace forefeel;
using testing::logs;
using testing::small_input;
using testing::virtual_options;

namespace {

void expect_no_state_twice(const SessionResult& result) {
  std::set<std::tuple<double, double, double>> solved;
  for (const DispatchRecord& d : result.dispatch)
    if (d.status == DispatchStatus::solved) REQUIRE(solved.insert({d.at.x(), d.at.y(), d.at.z()}).second);
}

}  // namespace

TEST_CASE("virtual clock: same seed, same bytes, whatever the threads") {
  const test::TemporaryFolder folder;
  for (const std::string& policy :
       {std::string("coverage"), std::string("nearest"), std::string("clairvoyant")}) {
    SessionOptions options = virtual_options(1.5);
    options.planning.policy = policy;
    options.workers.cost = LogNormalCost{0.02, 0.8};
    options.workers.latency = 0.003;
    options.workers.count = 3;
    options.seed = 5;
    options.motion.device = PathMotion{.path = PathName::reach, .speed = 0.06, .tremor = 0.0001};
    options.workers.threads = 1;
    const std::string one = logs(small_input(), options, folder / "one");
    options.workers.threads = 2;
    CHECK(one == logs(small_input(), options, folder / "two"));
    options.workers.threads = 7;
    SessionInput cached = small_input();
    cached.files.cache = folder / "cache";
    CHECK(one == logs(cached, options, folder / "fresh cache"));
    CHECK(one == logs(cached, options, folder / "full cache"));
    options.seed = 6;
    CHECK(one != logs(small_input(), options, folder / "other seed"));
  }
}

TEST_CASE("labels, first visits and positions that are worked out beside a run are those of its frames") {
  SessionOptions options = virtual_options(1.5);
  options.motion.device = PathMotion{.path = PathName::lissajous, .speed = 0.05};
  options.workers.cost = LogNormalCost{0.03, 0.8};
  std::vector<Vec3> positions;
  const SessionInput input = small_input();
  const SessionResult result =
      run_session(input, options, {}, {}, [&](const Vec3& at) { positions.push_back(at); });
  REQUIRE(positions.size() == result.frames.size());
  StateSpace space(input.touched.space);
  std::size_t inserted = 0, visits = 0;
  std::set<Label> seen;
  std::set<std::tuple<long, long, long>> cells;
  for (std::size_t k = 0; k < result.frames.size(); ++k) {
    const FrameRecord& frame = result.frames[k];
    CHECK(positions[k] == frame.at);
    for (; inserted < frame.known; ++inserted) space.insert(result.states.at(inserted));
    REQUIRE(frame.label == space.coverage(frame.at).label);
    seen.insert(frame.label);
    const Vec3 cell = (frame.at / input.touched.space.spacing).array().floor();
    const bool first =
        cells.insert({std::lround(cell[0]), std::lround(cell[1]), std::lround(cell[2])}).second;
    if (frame.judged.first_visit) {
      CHECK(first);
      CHECK(std::isfinite(frame.judged.error));
      ++visits;
    }
  }
  CHECK(seen.size() >= 3);
  CHECK(visits > 3);
}

TEST_CASE("what is rendered beside the planner is what is rendered in turn with it") {
  struct Answering final : Device {  // a motion that is said to depend on the force, and does not
    std::unique_ptr<Device> path;
    bool answers;
    Answering(std::unique_ptr<Device> device, bool yes) : path(std::move(device)), answers(yes) {}
    Vec3 position(double t, const Vec3& force) noexcept override { return path->position(t, force); }
    double duration() const override { return path->duration(); }
    bool answers_force() const override { return answers; }
  };
  const SessionInput input = small_input();
  SessionOptions options = virtual_options(1.2);
  options.workers.count = 3;
  options.planning.batch = 1;
  for (const SwitchRule rule : {SwitchRule::smooth, SwitchRule::paper, SwitchRule::none}) {
    options.switching.rule = rule;
    const auto run = [&](bool in_turn, std::size_t frames) {
      SessionPlan plan = make_plan(input, options);
      plan.frames = frames;
      plan.device = std::make_unique<Answering>(
          make_device(PathMotion{.path = PathName::lissajous, .speed = 0.06, .tremor = 0.0001},
                      {.box = input.touched.space.box, .seed = 3, .folder = {}}),
          in_turn);
      ReferenceService references(reference_options(input), 2);
      const auto cost =
          make_cost(LogNormalCost{0.03, 0.8}, {.seed = 3}, [&] { return references.recorded_costs(); });
      RunAnalysis analysis(judge_setup(plan), references, {});
      SessionResult result;
      run_virtual(plan, *cost, references, analysis, result, {});
      analysis.finish(result, {});
      return result;
    };
    for (const std::size_t frames : {1u, 99u, 100u, 1200u}) {
      const SessionResult one = run(true, frames), other = run(false, frames);
      REQUIRE(one.frames.size() == frames);
      REQUIRE(other.frames.size() == frames);
      for (std::size_t k = 0; k < frames; ++k) {
        const FrameRecord &a = one.frames[k], &b = other.frames[k];
        REQUIRE((a.t == b.t && a.at == b.at && a.force == b.force && a.sent == b.sent &&
                 a.undamped == b.undamped));
        REQUIRE((a.label == b.label && a.model == b.model && a.known == b.known &&
                 a.step.took_model == b.step.took_model));
        REQUIRE((a.step.change == b.step.change && a.step.motion_change == b.step.motion_change &&
                 a.judged.first_visit == b.judged.first_visit));
      }
      REQUIRE(one.switches.size() == other.switches.size());
      for (std::size_t i = 0; i < one.switches.size(); ++i) {
        CHECK(one.switches[i].t == other.switches[i].t);
        CHECK(one.switches[i].cause == other.switches[i].cause);
      }
      REQUIRE(one.dispatch.size() == other.dispatch.size());
      std::size_t used = 0;
      for (std::size_t i = 0; i < one.dispatch.size(); ++i) {
        const double a = one.dispatch[i].first_used, b = other.dispatch[i].first_used;
        CHECK((a == b || (std::isnan(a) && std::isnan(b))));
        used += std::isfinite(a) ? 1 : 0;
      }
      if (frames == 1200) CHECK(used > 5);
      CHECK(one.safety.work == other.safety.work);
    }
  }
}

TEST_CASE("clairvoyant is a bound: no policy that it rehearses is within the JND at more first visits") {
  for (const PathMotion& device : {PathMotion{.path = PathName::reach, .speed = 0.15, .tremor = 0.0002},
                                   PathMotion{.path = PathName::line, .speed = 0.07}}) {
    SessionOptions options = virtual_options(1);
    options.workers.cost = LogNormalCost{0.1, 0.6};
    options.motion.device = device;
    options.judging.reference_step = 0.05;
    const auto share = [&](const std::string& policy) {
      options.planning.policy = policy;
      return summarise(run_session(small_input(), options), small_input(), options)
          .error.first_visit.within_jnd;
    };
    const double bound = share("clairvoyant");
    for (const std::string policy : {"coverage", "nearest", "direction", "clairvoyant-greedy"}) {
      CAPTURE(device, policy);
      CHECK(share(policy) <= bound);
    }
  }
}

TEST_CASE("virtual clock: starts with nothing, fades in, accounts for everything") {
  SessionInput input = small_input();
  SessionOptions options = virtual_options(2);
  options.workers.count = 4;
  const SessionResult r = run_session(input, options);
  REQUIRE(r.frames.size() == 2000);
  CHECK(r.frames.front().known == 0);
  CHECK(r.frames.front().label == Label::blank);
  CHECK(r.frames.front().force == Vec3::Zero());
  CHECK(r.frames.front().at == Vec3::Zero());
  CHECK(r.counts.start == 0);
  CHECK(r.counts.solved == 125);
  CHECK(r.counts.failed == 0);
  CHECK(r.states.size() == 125);
  expect_no_state_twice(r);
  std::size_t over = 0;
  for (std::size_t k = 1; k < r.frames.size(); ++k) {
    REQUIRE(r.frames[k].known >= r.frames[k - 1].known);
    over += r.frames[k].step.change > r.frames[k].step.bound;
    // The change of the force is what motion and the switch make, nothing else.
    REQUIRE((r.frames[k].force - r.frames[k - 1].force).norm() <=
            r.frames[k].step.change + r.frames[k].step.motion_change + 1e-12);
  }
  CHECK(over == 0);
  for (const DispatchRecord& d : r.dispatch) {
    CHECK(d.started <= d.finished);
    if (d.status == DispatchStatus::solved)
      CHECK(d.finished - d.started == Approx(d.at.isZero(0) ? 0.0025 : 0.01).margin(2e-9));
    CHECK(d.known == d.finished);
    CHECK(d.worker >= 0);
    CHECK(d.worker < 4);
    CHECK(d.parent < static_cast<std::int64_t>(d.id));
  }
  // Rest after 2.5 ms, then four workers of 10 ms each: 400 states a second.
  CHECK(r.frames[105].known == 41);
  // Once the box is full, what is inside it is safe and exact to well under the JND.
  const FrameRecord& late = r.frames.back();
  CHECK(late.known == 125);
  double worst = 0;
  for (const FrameRecord& f : r.frames)
    if (f.t > 1 && std::isfinite(f.judged.approximation) && input.touched.space.box.contains(f.at)) {
      CHECK(f.label == Label::safe);
      worst = std::max(worst, f.judged.approximation);
    }
  CHECK(worst > 0);
  CHECK(worst < 0.02);

  const SessionSummary summary = summarise(r, input, options);
  CHECK(summary.states.solved == 125);
  CHECK(summary.states.used + summary.states.wasted == 125);
  CHECK(summary.switching.frames_over_jnd == 0);
  CHECK(summary.switching.count == r.switches.size());
  CHECK(std::isnan(summary.deadline.cost_us.p50));
  double shares = 0;
  for (const Label label : all_labels) shares += summary.time_in[label];
  CHECK(shares == Approx(1));
  CHECK(summary.error.samples.samples > 40);
  CHECK(summary.load > 0);
}

TEST_CASE(
    "virtual clock: the state at rest comes first, at the cost of a factorisation; the first model is its "
    "tangent") {
  for (const Placement placement : {Placement::lattice, Placement::adaptive, Placement::path})
    for (const bool fast : {false, true}) {
      CAPTURE(static_cast<int>(placement), fast);
      SessionOptions options = virtual_options(0.3);
      options.planning.placement = placement;
      options.workers.count = 3;
      options.model.first_guess = false;
      options.workers.cost = ConstantCost{0.08};
      options.workers.latency = 0.001;
      options.motion.device =
          fast ? PathMotion{.path = PathName::lissajous, .speed = 0.5} : PathMotion{.speed = 0.02};
      const SessionResult r = run_session(small_input(), options);
      REQUIRE(r.dispatch.size() > 3);
      const DispatchRecord& rest = r.dispatch.front();
      CHECK(rest.at == Vec3::Zero());
      CHECK(rest.status == DispatchStatus::solved);
      CHECK(rest.started == Approx(0.001));
      CHECK(rest.finished == Approx(0.021));
      CHECK(rest.known == Approx(0.022));
      // The others wait for the hand to move a third of a spacing, at most for rest.
      double others = INFINITY;
      for (const DispatchRecord& d : r.dispatch)
        if (d.id > 0) others = std::min(others, d.started);
      const auto moved = std::ranges::find_if(r.frames, [&](const FrameRecord& f) {
        return f.at.norm() >= small_input().touched.space.spacing / 3;
      });
      const double told = std::min(moved == r.frames.end() ? INFINITY : moved->t, rest.known);
      CHECK(others == Approx(told + 0.001));
      CHECK((others < rest.finished) == fast);
      for (const FrameRecord& f : r.frames) {
        REQUIRE(f.step.change <= f.step.bound);
        if (f.known == 0) CHECK(f.force == Vec3::Zero());
        if (f.model == 1)
          CHECK((f.undamped + r.states[0].stiffness * f.at).norm() <= 1e-9 * (1 + f.undamped.norm()));
      }
      CHECK(r.states[0].at == Vec3::Zero());
      CHECK(r.counts.start == 0);
      CHECK(std::ranges::count(r.states, Vec3(Vec3::Zero()), &State::at) == 1);
      options.planning.rest_first = false;  // then it costs what any other does
      const SessionResult plain = run_session(small_input(), options);
      CHECK(plain.dispatch.front().started == Approx(0.001));
      for (const DispatchRecord& d : plain.dispatch)
        if (d.status == DispatchStatus::solved) CHECK(d.finished - d.started == Approx(0.08));
    }
}

TEST_CASE(
    "virtual clock: until something is known the hand feels the first guess, and the first state replaces "
    "it") {
  SessionOptions options = virtual_options(0.6);
  options.workers.cost = ConstantCost{0.4};  // rest after 0.1 s
  options.motion.device = PathMotion{.path = PathName::lissajous, .speed = 0.03};
  const Mat3 guess = disc_stiffness(*small_input().touched.body);
  const auto is_guess = [&](const FrameRecord& f) {
    return (f.undamped + guess * f.at).norm() <= 1e-9 * (guess * f.at).norm();
  };
  for (const SessionMethod method : {SessionMethod::rbf, SessionMethod::tricubic})
    for (const Data data : {Data::force, Data::force_and_stiffness}) {
      CAPTURE(static_cast<int>(method), name(data));
      options.model.method = method;
      options.model.fit.data = data;
      const SessionResult r = run_session(small_input(), options);
      CHECK(r.counts.start == 0);
      std::size_t before = 0, after = 0;
      for (const FrameRecord& f : r.frames) {
        REQUIRE(f.step.change <= f.step.bound);
        if (f.known == 0) {
          ++before;
          REQUIRE(is_guess(f));
          REQUIRE((f.force - f.undamped).norm() <= 1e-12);  // from rest on: nothing fades in
          REQUIRE(f.label == Label::blank);
        } else if (f.at.norm() > 1e-3) {
          ++after;
          REQUIRE_FALSE(is_guess(f));
        }
      }
      CHECK(before == 100);
      CHECK(after > 400);
      REQUIRE(r.switches.size() >= 2);
      CHECK(r.switches[0].cause == SwitchCause::guess);
      CHECK(r.switches[0].n == 0);
      CHECK(r.switches[1].cause == SwitchCause::first);
      CHECK(r.switches[1].jump_undamped > 0);
      CHECK(r.switches[1].t == Approx(0.1).margin(0.0011));
      // what is known, asked for and solved is the same without it
      options.model.first_guess = false;
      const SessionResult without = run_session(small_input(), options);
      options.model.first_guess = true;
      REQUIRE(without.dispatch.size() == r.dispatch.size());
      for (std::size_t i = 0; i < r.dispatch.size(); ++i) {
        CHECK(without.dispatch[i].at == r.dispatch[i].at);
        CHECK((without.dispatch[i].finished == r.dispatch[i].finished || std::isnan(r.dispatch[i].finished)));
      }
      for (const FrameRecord& f : without.frames)
        if (f.known == 0) REQUIRE(f.force == Vec3::Zero());
    }
}

TEST_CASE("the first guess has no say where states come from elsewhere, and is replayed with its run") {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "late.csv") << "t,x,y,z\n0.1,0,0,0\n";
  SessionOptions options = virtual_options(0.2);
  options.workers.cost = ConstantCost{0.4};
  const SessionResult solved = run_session(small_input(), options);
  std::filesystem::create_directories(folder / "solved");
  std::filesystem::create_directories(folder / "arrived");
  write_run_files(folder / "solved", solved, options);
  CHECK(summarise(solved, small_input(), options).run.first_guess);
  SessionOptions arriving = options;
  arriving.planning.arrivals = folder / "late.csv";
  const SessionResult arrived = run_session(small_input(), arriving);
  for (const FrameRecord& f : arrived.frames)
    if (f.known == 0) REQUIRE(f.force == Vec3::Zero());
  CHECK_FALSE(summarise(arrived, small_input(), arriving).run.first_guess);
  write_run_files(folder / "arrived", arrived, arriving);
  for (const auto& [run, recorded] : {std::pair{"solved", &solved}, std::pair{"arrived", &arrived}}) {
    CAPTURE(run);
    SessionOptions again = options;
    again.motion.replay = folder / run;
    const SessionResult replayed = run_session(small_input(), again);
    REQUIRE(replayed.frames.size() == recorded->frames.size());
    for (std::size_t k = 0; k < replayed.frames.size(); ++k)
      REQUIRE((replayed.frames[k].force - recorded->frames[k].force).norm() <= 1e-9);
  }
}

TEST_CASE("times that cannot be and a box without room are refused, naming the row or the key") {
  const test::TemporaryFolder folder;
  const auto refused = [&](const char* name, const std::string& rows, bool arrivals) {
    std::ofstream(folder / name) << "t,x,y,z\n" << rows;
    SessionOptions options = virtual_options(0.1);
    if (arrivals)
      options.planning.arrivals = folder / name;
    else
      options.motion.device = TraceMotion{.file = folder / name};
    try {
      check_session(small_input(), options);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(refused("twice.csv", "0,0,0,0\n0.1,0,0,-0.001\n0.1,0,0,-0.002\n", false),
             Catch::Contains("twice.csv:4: a second row at 0.1 s"));
  CHECK(refused("good.csv", "0,0,0,0\n0.1,0,0,-0.001\n0.2,0,0,-0.002\n", false).empty());
  CHECK_THAT(refused("late.csv", "0,0,0,0\n1e300,0,0,-0.006\n", true),
             Catch::Contains("late.csv:3") && Catch::Contains("86400"));
  CHECK(refused("same.csv", "1,0,0,0\n1,0,0,-0.006\n", true).empty());  // states may come together
  SessionInput point = small_input();
  point.touched.space.box = {Vec3::Zero(), Vec3::Zero()};
  CHECK_THROWS_WITH(check_session(point, virtual_options(0.1)),
                    Catch::Contains("state_space.box") && Catch::Contains("room"));
}

TEST_CASE("summary: every key of the contract") {
  const SessionInput input = small_input();
  const SessionOptions options = virtual_options(0.2);
  std::set<std::string> names;
  for (const Column& column : summary_columns(summarise(run_session(input, options), input, options)))
    CHECK(names.insert(column.name).second);
  for (const std::string key : {"clock",
                                "seconds",
                                "frames",
                                "deadline.missed",
                                "deadline.cost_us.p50",
                                "deadline.cost_us.p99",
                                "deadline.cost_us.max",
                                "deadline.lateness_us.p50",
                                "deadline.lateness_us.p99",
                                "deadline.lateness_us.max",
                                "states.start",
                                "states.solved",
                                "states.used",
                                "states.wasted",
                                "states.preempted",
                                "states.failed",
                                "states.age_at_use_ms.p50",
                                "states.age_at_use_ms.p99",
                                "time_in.safe",
                                "time_in.sparse",
                                "time_in.gap",
                                "time_in.blank",
                                "switch.count",
                                "switch.rule",
                                "switch.max_jump",
                                "switch.max_jump_undamped",
                                "switch.frames_over_jnd",
                                "switch.drift.ms50",
                                "switch.drift.ms100",
                                "switch.drift.ms300",
                                "error.reference",
                                "error.samples",
                                "error.p50",
                                "error.p95",
                                "error.max",
                                "error.within_jnd",
                                "error.parts.approximation",
                                "error.parts.switch",
                                "error.parts.staleness",
                                "error.by_label.safe.p95",
                                "error.first_visit.p50",
                                "error.first_visit.p95",
                                "error.first_visit.within_jnd",
                                "load",
                                "energy.generated_J",
                                "energy.work_J",
                                "safety.clamped",
                                "safety.slewed",
                                "safety.stale",
                                "safety.non_finite",
                                "workers",
                                "policy",
                                "select",
                                "seed"}) {
    CAPTURE(key);
    CHECK(names.contains(key));
  }
}

TEST_CASE("every policy, every switch rule, preemption and many workers run to the end") {
  for (const std::string& policy : policy_names()) {
    for (const int workers : {1, 40}) {
      CAPTURE(policy, workers);
      SessionOptions options = virtual_options(0.6);
      options.planning.policy = policy;
      options.workers.count = workers;
      options.workers.cost = ConstantCost{0.05};
      const SessionResult r = run_session(small_input(Law::linear), options);
      CHECK(r.frames.size() == 600);
      expect_no_state_twice(r);
      CHECK(r.states.size() == r.counts.solved);
      CHECK(r.states.size() > 5);
    }
  }
  for (const SwitchRule rule : {SwitchRule::paper, SwitchRule::smooth, SwitchRule::none}) {
    SessionOptions options = virtual_options(0.6);
    options.switching.rule = rule;
    const SessionResult r = run_session(small_input(), options);
    std::size_t over = 0;
    for (const FrameRecord& f : r.frames) over += f.step.change > f.step.bound;
    if (rule != SwitchRule::none) CHECK(over == 0);
    if (rule == SwitchRule::none) CHECK(over > 0);
  }
}

TEST_CASE("a linear body needs three solves: states are exact multiples") {
  const SessionResult r = run_session(small_input(Law::linear), virtual_options(0.8));
  REQUIRE(r.states.size() > 20);
  const Mat3 k = r.states.front().stiffness;
  CHECK((k - k.transpose()).norm() < 1e-9 * k.norm());
  Solver solver(testing::small_body(Law::linear));
  for (const State& state : r.states) {
    CHECK((state.force + k * state.at).norm() <= 1e-12);
    if (state.at.norm() == 0) continue;
    const State tight = solver.reference(state.at, 0.006).state;
    CHECK((state.force - tight.force).norm() < 1e-8 * tight.force.norm());
    CHECK(state.energy == Approx(tight.energy).epsilon(1e-8));
  }
}

TEST_CASE("arrivals: states are known when the file says") {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "a.csv")
      << "t,x,y,z\n0.1,0,0,0\n0.25,0.006,0,0\n0.25,0,0.006,0\n0.05,0,0,0.006\n9,0.012,0,0\n";
  SessionOptions options = virtual_options(0.5);
  options.planning.arrivals = folder / "a.csv";
  const SessionResult r = run_session(small_input(), options);
  const auto known = [&](double t) {
    return r.frames[static_cast<std::size_t>(std::lround(t * 1000))].known;
  };
  CHECK(known(0.049) == 0);
  CHECK(known(0.05) == 1);
  CHECK(known(0.099) == 1);
  CHECK(known(0.1) == 2);
  CHECK(known(0.249) == 2);
  CHECK(known(0.25) == 4);
  CHECK(r.frames.back().known == 4);
  REQUIRE(r.dispatch.size() == 4);
  CHECK(r.dispatch.front().status == DispatchStatus::arrived);
  CHECK(r.dispatch.front().at == Vec3(0, 0, 0.006));

  options.clock.kind = Clock::real;
  const SessionResult real = run_session(small_input(), options);
  CHECK(real.states.size() == 4);
  CHECK(real.dispatch.size() == 4);
}

TEST_CASE("replay: a recorded run gives the same forces again") {
  const test::TemporaryFolder folder;
  SessionOptions options = virtual_options(1);
  options.workers.cost = LogNormalCost{0.02, 0.5};
  options.workers.latency = 0.002;
  options.motion.device = PathMotion{.path = PathName::tour, .speed = 0.06, .tremor = 0.0001};
  prepare_run_folder(folder / "run");
  const SessionResult first = run_session(small_input(), options);
  write_run_files(folder / "run", first, options);
  options.motion.replay = folder / "run";
  options.motion.device = PathMotion{.path = PathName::press};
  const SessionResult second = run_session(small_input(), options);
  REQUIRE(second.frames.size() == first.frames.size());
  for (std::size_t k = 0; k < first.frames.size(); ++k) {
    REQUIRE(second.frames[k].at == first.frames[k].at);
    REQUIRE(second.frames[k].force == first.frames[k].force);
    REQUIRE(second.frames[k].known == first.frames[k].known);
    REQUIRE(second.frames[k].label == first.frames[k].label);
  }
  CHECK(second.switches.size() == first.switches.size());
}

TEST_CASE("states of the start are used, kept and not solved again") {
  const test::TemporaryFolder folder;
  SessionInput input = small_input();
  input.files.states = folder / "a.states";
  const SessionResult first = run_session(input, virtual_options(0.3));
  const std::size_t solved = first.states.size();
  REQUIRE(solved > 10);
  CHECK(StateFile::open_read_only(folder / "a.states").read_all().size() == solved);

  input.known = StateFile::open_read_only(folder / "a.states").read_all();
  const SessionResult second = run_session(input, virtual_options(0.3));
  CHECK(second.counts.start == solved);
  CHECK(second.frames.front().known == solved);
  CHECK(second.states.size() == solved + second.counts.solved);
  const auto all = StateFile::open_read_only(folder / "a.states").read_all();
  CHECK(all.size() == second.states.size());
  std::set<std::tuple<double, double, double>> places;
  for (const State& state : all) CHECK(places.insert({state.at.x(), state.at.y(), state.at.z()}).second);
}

TEST_CASE("real clock: renders, solves and reports") {
  SessionInput input = small_input();
  SessionOptions options = virtual_options(0.4);
  options.clock.kind = Clock::real;
  options.workers.count = 2;
  const SessionResult r = run_session(input, options);
  REQUIRE(r.frames.size() == 400);
  CHECK(r.solver.workers == 2);
  CHECK(r.states.size() > 0);
  CHECK(r.counts.solved == r.states.size());
  expect_no_state_twice(r);
  std::size_t over = 0, taken = 0;
  for (const FrameRecord& f : r.frames) {
    REQUIRE(f.sent.allFinite());
    REQUIRE(std::isfinite(f.timing.cost_us));
    REQUIRE(std::isfinite(f.timing.lateness_us));
    over += f.step.change > f.step.bound;
    taken += f.step.took_model;
  }
  CHECK(over == 0);
  CHECK(taken == r.switches.size());
  CHECK(taken > 0);
  for (const State& state : r.states) {
    CHECK(state.usable());
    CHECK(state.has_stiffness());
  }
  const SessionSummary summary = summarise(r, input, options);
  CHECK(summary.settings.clock == Clock::real);
  CHECK(std::isfinite(summary.deadline.cost_us.p50));
  if (!r.process.realtime_priority) CHECK(!r.notes.empty());  // said so
}

TEST_CASE("bad sessions are refused before anything is solved or written") {
  const test::TemporaryFolder folder;
  const auto refuse = [&](auto change) {
    SessionOptions options = virtual_options(0.1);
    change(options);
    SessionInput input = small_input();
    input.files.states = folder / "none.states";
    CHECK_THROWS_AS(check_session(input, options), InputError);
    CHECK_THROWS_AS(run_session(input, options), InputError);
    CHECK_FALSE(std::filesystem::exists(folder / "none.states"));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuse([](SessionOptions& o) { o.planning.policy = "best"; });
  refuse([](SessionOptions& o) { o.workers.count = 0; });
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

// Run by the next test in a process of its own, which is killed.
TEST_CASE("session that is killed", "[.]") {
  SessionInput input = small_input();
  input.touched.space.spacing = 0.0015;  // thousands of states: far from done when it is killed
  input.files.states = std::getenv("FOREFEEL_TEST_STATES");
  SessionOptions options = virtual_options(20);
  options.clock.kind = Clock::real;
  run_session(input, options);
}

TEST_CASE("kill -9 loses nothing that was committed") {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "a.states";
  const pid_t child = fork();
  if (child == 0) {
    setenv("FOREFEEL_TEST_STATES", file.c_str(), 1);
    freopen("/dev/null", "w", stdout);
    execl("/proc/self/exe", "test_scheduling", "session that is killed", static_cast<char*>(nullptr));
    _exit(127);
  }
  std::size_t seen = 0;
  for (int tries = 0; tries < 3000 && seen < 20; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (!std::filesystem::exists(file)) continue;
    try {
      seen = StateFile::open_read_only(file).size();
    } catch (const InputError&) {  // not made yet
    }
  }
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  CHECK(WIFSIGNALED(status));
  REQUIRE(seen >= 20);
  const auto states = StateFile::open_read_only(file).read_all();
  CHECK(states.size() >= seen);
  for (const State& state : states) {
    CHECK(state.usable());
    CHECK(state.force.allFinite());
  }
  SessionInput input = small_input();
  input.files.states = file;
  input.known = states;
  CHECK(run_session(input, virtual_options(0.05)).counts.start == states.size());
}

TEST_CASE("older methods render from the lattice cell around the HIP, and wait for its corners") {
  for (const SessionMethod method : {SessionMethod::trilinear, SessionMethod::tricubic}) {
    CAPTURE(static_cast<int>(method));
    SessionOptions options = virtual_options(1.5);
    options.model.method = method;
    options.planning.policy = "nearest";
    options.switching.rule = SwitchRule::none;
    options.workers.count = 4;
    const SessionResult r = run_session(small_input(), options);
    CHECK(r.states.size() == 125);
    double early = 0,
           late = 0;  // inside the full lattice the method is good, before it holds the nearest force
    const Box inner{Vec3::Constant(-0.011), Vec3::Constant(0.011)};
    for (const FrameRecord& f : r.frames)
      if (std::isfinite(f.judged.approximation) && inner.contains(f.at)) {
        double& worst = f.t < 0.05 ? early : late;
        if (f.t < 0.05 || f.t > 0.6) worst = std::max(worst, f.judged.approximation);
      }
    CHECK(late > 0);
    CHECK(late < 0.06);
    for (const FrameRecord& f : r.frames) REQUIRE(f.force.allFinite());
  }
}

TEST_CASE("placement: on the octree's lattice, or on the predicted path, each place once") {
  for (const Placement placement : {Placement::adaptive, Placement::path}) {
    CAPTURE(static_cast<int>(placement));
    SessionOptions options = virtual_options(1);
    options.planning.placement = placement;
    options.workers.cost = ConstantCost{0.02};
    const SessionResult r = run_session(small_input(), options);
    CHECK(r.states.size() > 20);
    expect_no_state_twice(r);
    const double h = small_input().touched.space.spacing;
    std::size_t off = 0;  // the lattice
    for (const State& state : r.states) {
      const Vec3 share = state.at / h;
      off += (share - share.array().round().matrix()).norm() > 1e-6;
      CHECK(small_input().touched.space.box.contains(state.at));
    }
    CHECK((off > 0) == (placement == Placement::path));
  }
  // What is being solved keeps free positions away as what is known does.
  for (const std::string policy : {"nearest", "coverage"})
    for (const int workers : {2, 8}) {
      CAPTURE(policy, workers);
      SessionOptions options = virtual_options(1);
      options.planning.placement = Placement::path;
      options.planning.policy = policy;
      options.workers.count = workers;
      options.workers.cost = ConstantCost{0.03};
      const SessionResult r = run_session(small_input(), options);
      CHECK(r.states.size() > 20);
      for (std::size_t i = 0; i < r.states.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
          REQUIRE((r.states[i].at - r.states[j].at).norm() >=
                  0.5 * small_input().touched.space.spacing - 1e-12);
    }
}

TEST_CASE(
    "two runs of one body share the cache of references: one writes, the other reads, the results are the "
    "same") {
  const test::TemporaryFolder folder;
  SessionInput input = small_input();
  input.files.cache = folder / "cache";
  const SessionOptions options = virtual_options(0.5);
  const SessionResult first = run_session(input, options);
  const ReferenceService writing(reference_options(input), 1);
  REQUIRE_FALSE(writing.note());
  const SessionResult second = run_session(input, options);
  const auto only_read = [](const std::string& note) { return note.find("only read") != std::string::npos; };
  CHECK(std::ranges::any_of(second.notes, only_read));
  CHECK(std::ranges::none_of(first.notes, only_read));
  REQUIRE(second.frames.size() == first.frames.size());
  for (std::size_t k = 0; k < first.frames.size(); ++k)
    REQUIRE(second.frames[k].force == first.frames[k].force);
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
