#include <fmt/format.h>

#include "run_logs.hpp"
#include "scheduling/record/run_files.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "scheduling/session/session.hpp"
#include "small_body.hpp"
#include "solver/equilibrium/first_guess.hpp"
#include "solver/equilibrium/solver.hpp"

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
        if (f.step.model == 1)
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
  const Mat3 guess = first_guess(block_input().touched.body).stiffness;
  const auto is_guess = [&](const FrameRecord& f) {
    return (f.undamped + guess * f.at).norm() <= 1e-9 * (guess * f.at).norm();
  };
  for (const SessionMethod method : {SessionMethod::rbf, SessionMethod::tricubic})
    for (const Data data : {Data::force, Data::force_and_stiffness}) {
      CAPTURE(static_cast<int>(method), name(data));
      options.model.method = method;
      options.model.fit.data = data;
      const SessionResult r = run_session(block_input(), options);
      CHECK(r.counts.start == 0);
      std::size_t before = 0, after = 0;
      for (const FrameRecord& f : r.frames) {
        REQUIRE(f.step.change <= f.step.bound);
        if (f.known == 0) {
          ++before;
          REQUIRE(is_guess(f));
          REQUIRE((f.force - f.undamped).norm() <= 1e-12);  // from rest on: nothing fades in
          REQUIRE(f.label == Label::blank);
        } else if (f.known > 1) {  // the tangent at rest is the same as the guess
          after += is_guess(f) ? 0 : 1;
        }
      }
      CHECK(before == 100);
      CHECK(after >= 100);
      REQUIRE(r.switches.size() >= 2);
      CHECK(r.switches[0].cause == SwitchCause::guess);
      CHECK(r.switches[0].n == 0);
      CHECK(r.switches[1].cause == SwitchCause::first);
      CHECK(r.switches[1].t == Approx(0.1).margin(0.0011));
      // known, requested and solved states are the same without it
      options.model.first_guess = false;
      const SessionResult without = run_session(block_input(), options);
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
  const TemporaryFolder folder;
  std::ofstream(folder / "late.csv") << "t,x,y,z\n0.1,0,0,0\n";
  SessionOptions options = virtual_options(0.2);
  options.workers.cost = ConstantCost{0.4};
  const SessionResult solved = run_session(block_input(), options);
  fs::create_directories(folder / "solved");
  fs::create_directories(folder / "arrived");
  write_run_files(folder / "solved", solved, options);
  CHECK(summarise(solved, block_input(), options).run.first_guess);
  SessionOptions arriving = options;
  arriving.planning.arrivals = folder / "late.csv";
  const SessionResult arrived = run_session(block_input(), arriving);
  for (const FrameRecord& f : arrived.frames)
    if (f.known == 0) REQUIRE(f.force == Vec3::Zero());
  CHECK_FALSE(summarise(arrived, block_input(), arriving).run.first_guess);
  write_run_files(folder / "arrived", arrived, arriving);
  for (const auto& [run, recorded] : {std::pair{"solved", &solved}, std::pair{"arrived", &arrived}}) {
    CAPTURE(run);
    SessionOptions again = options;
    again.motion.replay = folder / run;
    const SessionResult replayed = run_session(block_input(), again);
    REQUIRE(replayed.frames.size() == recorded->frames.size());
    for (std::size_t k = 0; k < replayed.frames.size(); ++k)
      REQUIRE((replayed.frames[k].force - recorded->frames[k].force).norm() <= 1e-9);
  }
}

TEST_CASE("on a slender body the first guess is near the truth, and its error bar holds it") {
  SessionOptions options = virtual_options(0.4);
  options.workers.cost = ConstantCost{1.2};  // rest after 0.3 s
  options.motion.device = PathMotion{.path = PathName::lissajous, .speed = 0.03};
  for (const bool slender : {true, false}) {
    CAPTURE(slender);
    const SessionInput input = slender ? small_input() : block_input();
    const SessionResult r = run_session(input, options);
    const SessionSummary summary = summarise(r, input, options);
    CHECK(summary.run.first_guess);
    CHECK((summary.run.guess_softness > 10) == slender);
    Solver solver(input.touched.body);
    std::size_t compared = 0, inside = 0;
    for (std::size_t k = 20; k < r.frames.size() && r.frames[k].known == 0; k += 20) {
      const FrameRecord& f = r.frames[k];
      const Vec3 truth = solver.reference(f.at, 0.006).state.force;
      CAPTURE(f.t, f.at.transpose(), truth.transpose(), f.force.transpose(), f.bar.half_width[1]);
      REQUIRE(std::isfinite(f.bar.half_width[1]));
      CHECK((f.force - truth).norm() < 0.36 * truth.norm());
      ++compared;
      inside += (f.force - truth).norm() <= f.bar.half_width[1];
    }
    CHECK(compared >= 10);
    CHECK(inside >= compared - 1);
  }
  options.model.first_guess = false;
  const SessionResult without = run_session(small_input(), options);
  CHECK(std::isnan(without.run.guess_softness));
  for (const FrameRecord& f : without.frames)
    if (f.known == 0) {
      REQUIRE(f.force == Vec3::Zero());
      REQUIRE_FALSE(std::isfinite(f.bar.half_width[1]));
    }
}

TEST_CASE(
    "a body too large for a first guess: nothing is rendered until something is known, and a note says why") {
  SessionOptions options = virtual_options(0.05);
  SessionInput input = small_input();
  auto large = std::make_shared<Body>(*input.touched.body);
  // Nodes that no tetrahedron uses make it large without making it slow.
  large->mesh.nodes.resize(most_guess_nodes + 1, Vec3::Zero());
  input.touched.body = large;
  const SessionResult r = run_session(input, options);
  CHECK(std::ranges::any_of(r.notes, [](const std::string& note) {
    return note.starts_with(fmt::format("no first guess: the body has {} nodes", most_guess_nodes + 1));
  }));
  CHECK_FALSE(summarise(r, input, options).run.first_guess);
  for (const FrameRecord& f : r.frames)
    if (f.known == 0) REQUIRE(f.force == Vec3::Zero());
}
