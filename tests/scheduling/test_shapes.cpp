// Shapes of a session against tight solves; what they may not change; the thread of its own.

#include "run_logs.hpp"
#include "scheduling/record/shape_files.hpp"
#include "scheduling/session/shaped_session.hpp"
#include "scheduling/shape/shape_thread.hpp"
#include "scheduling/workers/state_solver.hpp"
#include "small_body.hpp"
#include "solver/equilibrium/solver.hpp"
#include "touched_liver.hpp"

namespace {

State solved(const std::shared_ptr<const Body>& body, const Vec3& x) {
  Solver solver(body);
  return solver.reference(x, 0.006, {.want_displacements = true}).state;
}

// Largest distance of a node from where it is in the state, and the largest displacement there [m].
struct Misfit {
  double error = 0, largest = 0;
};
Misfit misfit(const ShapeLog& log, const ShapeRecord& record, const State& truth) {
  std::vector<float> u;
  log.displacements(record, u);
  Misfit found;
  for (std::size_t i = 0; i < log.nodes().size(); ++i) {
    const Vec3 exact = Eigen::Map<const Vec3>(truth.displacements->data() + 3 * log.nodes()[i]);
    found.error =
        std::max(found.error, (Eigen::Map<Eigen::Vector3f>(&u[3 * i]).cast<double>() - exact).norm());
    found.largest = std::max(found.largest, exact.norm());
  }
  return found;
}

// The largest relative error of shapes between states of a lattice.
double error_at_spacing(const std::shared_ptr<const Body>& body, double h) {
  ShapeLog log(body, {.rate = 30, .surface = false});
  for (const Vec3& x : lattice({Vec3::Constant(-0.0121), Vec3::Constant(0.0121)}, h))
    log.learn(solved(body, x));
  double worst = 0;
  for (const Vec3& x :
       {Vec3(0.0061, 0.0042, 0.0055), Vec3(-0.0035, 0.0071, -0.0052), Vec3(0.0018, -0.0079, 0.0083)}) {
    log.take(0, x);
    const Misfit found = misfit(log, log.records().back(), solved(body, x));
    worst = std::max(worst, found.error / found.largest);
  }
  return worst;
}

ShapedRun shapes_for(const SessionInput& input, const ShapeOptions& options, EachShape each = {}) {
  return {.log = std::make_shared<ShapeLog>(input.touched.body, options, std::move(each))};
}

SessionInput shaped_input(Law law = Law::neo_hookean) {
  SessionInput input = small_input(law);
  input.touched.displacements = true;
  return input;
}

}  // namespace

TEST_CASE("a linear body's shape is exact, with any states or none") {
  const auto body = small_body(Law::linear);
  ShapeLog log(body, {.rate = 30, .surface = false});
  const Vec3 x(0.004, -0.007, 0.009);
  for (const Vec3& next :
       {Vec3(0, 0, 0), Vec3(0, 0.003, 0), Vec3(0, 0.006, 0), Vec3(0.006, 0.001, 0.002), Vec3(0, 0, 0.01),
        Vec3(-0.01, 0.01, 0.01), Vec3(0.01, 0.01, 0.01), Vec3(0, -0.01, 0)}) {
    log.take(0, x);
    const Misfit found = misfit(log, log.records().back(), solved(body, x));
    CHECK(found.error < 1e-6 * found.largest);
    log.learn(solved(body, next));
  }
}

TEST_CASE("at a state the shape is that of the state, and the contact moves by the tip's displacement") {
  const auto body = small_body();
  ShapeLog log(body, {.rate = 30, .surface = false});
  std::vector<State> states;
  for (const Vec3& x : lattice({Vec3::Constant(-0.0121), Vec3::Constant(0.0121)}, 0.006))
    states.push_back(solved(body, x));
  for (const State& state : states) log.learn(state);
  for (std::size_t i = 0; i < states.size(); i += 7) {
    log.take(0, states[i].at);
    CHECK(misfit(log, log.records().back(), states[i]).error < 1e-7);  // [m], of up to 2 cm
  }
  std::vector<float> u;
  for (const Vec3& x :
       {Vec3(0.003, 0.001, -0.004), Vec3(0.03, 0.02, -0.02)}) {  // within the states, far outside
    log.take(0, x);
    log.displacements(log.records().back(), u);
    for (const NodeIndex node : body->contact)
      CHECK((Eigen::Map<Eigen::Vector3f>(&u[3 * static_cast<std::size_t>(node)]).cast<double>() - x).norm() <
            1e-7);
    for (const NodeIndex node : body->clamp)
      CHECK(Eigen::Map<Eigen::Vector3f>(&u[3 * static_cast<std::size_t>(node)]).norm() == 0);
  }
}

TEST_CASE("on a nonlinear body the error falls with the spacing") {
  const auto body = small_body();
  const double coarse = error_at_spacing(body, 0.012), middle = error_at_spacing(body, 0.006),
               fine = error_at_spacing(body, 0.003);
  INFO(coarse << ' ' << middle << ' ' << fine);
  CHECK(middle < coarse / 4);
  CHECK(fine < middle / 8);
  CHECK(fine < 1e-4);
}

TEST_CASE("virtual clock: one shape an instant, the same bits each time, and the same frames as without") {
  SessionOptions options = virtual_options(1);
  options.seed = 3;
  const SessionResult without = run_session(small_input(), options);
  std::vector<ShapedRun> runs;
  for (int i = 0; i < 2; ++i) {
    runs.push_back(shapes_for(small_input(), {.rate = 30, .checks = 12}));
    const SessionResult with = run_session(make_plan(shaped_input(), options), {}, &runs.back());
    REQUIRE(with.failures.empty());
    REQUIRE(with.frames.size() == without.frames.size());
    for (std::size_t k = 0; k < with.frames.size(); ++k) {
      REQUIRE(with.frames[k].sent == without.frames[k].sent);
      REQUIRE(with.frames[k].known == without.frames[k].known);
    }
    const auto records = runs.back().log->records();
    REQUIRE(records.size() == 30);
    for (std::size_t k = 0; k < records.size(); ++k) {
      CHECK(records[k].t == Approx(std::ceil(1000 * static_cast<double>(k) / 30 - 1e-9) / 1000));
      CHECK(records[k].at == with.frames[static_cast<std::size_t>(std::lround(1000 * records[k].t))].at);
      CHECK(records[k].known ==
            with.frames[static_cast<std::size_t>(std::lround(1000 * records[k].t))].known);
    }
    CHECK(runs.back().checked.size() == 12);
  }
  for (std::size_t k = 0; k < 30; ++k) {
    CHECK(runs[0].log->records()[k].weights == runs[1].log->records()[k].weights);
    CHECK(runs[0].log->records()[k].states == runs[1].log->records()[k].states);
  }
}

TEST_CASE("the error that is told is that of tight solves made here") {
  const SessionInput input = shaped_input();
  ShapedRun shapes = shapes_for(input, {.rate = 25, .checks = 6});
  const SessionResult result = run_session(make_plan(input, virtual_options(1)), {}, &shapes);
  REQUIRE(shapes.checked.size() == 6);
  double worst = 0;
  for (const CheckedShape& one : shapes.checked) {
    const ShapeRecord& record = shapes.log->records()[one.record];
    const Misfit found = misfit(*shapes.log, record, solved(input.touched.body, record.at));
    CHECK(one.error == Approx(found.error / std::max(found.largest, 1e-4)).margin(1e-6));
    CHECK(one.node_p95 <= one.error);
    worst = std::max(worst, one.error);
  }
  const ShapeSummary summary = summarise(*shapes.log, shapes.checked);
  CHECK(summary.error.samples == 6);
  CHECK(summary.error.max == worst);
  CHECK(summary.shapes == 25);
}

TEST_CASE("a hand that yields to the force has shapes too") {
  SessionInput input = shaped_input();
  SessionOptions options = virtual_options(0.5);
  options.motion.device = HandMotion{};
  ShapedRun shapes = shapes_for(input, {.rate = 60, .surface = false, .checks = 3});
  const SessionResult result = run_session(make_plan(input, options), {}, &shapes);
  CHECK(result.failures.empty());
  CHECK(shapes.log->records().size() == 30);
  CHECK(shapes.log->nodes().size() == input.touched.body->mesh.nodes.size());
  CHECK(shapes.checked.size() == 3);
}

TEST_CASE("real clock: shapes come at their rate from a thread of their own") {
  const SessionInput input = shaped_input();
  SessionOptions options = virtual_options(1);
  options.clock.kind = Clock::real;
  options.workers.count = 2;
  std::set<std::thread::id> threads;
  std::size_t told = 0;
  ShapedRun shapes =
      shapes_for(input, {.rate = 50, .checks = 4}, [&](const ShapeRecord& record, std::span<const float> u) {
        threads.insert(std::this_thread::get_id());
        told += u.size() == 60 && record.at.allFinite();  // all of the beam's 20 nodes are on the surface
      });
  const SessionResult result = run_session(make_plan(input, options), {}, &shapes);
  CHECK(result.failures.empty());
  const auto records = shapes.log->records();
  CHECK(told == records.size());
  CHECK(threads.size() == 1);
  CHECK(threads.count(std::this_thread::get_id()) == 0);
  REQUIRE(records.size() > 2);
  CHECK(records.size() + shapes.log->missed() <= 52);  // 50, and an instant on either side
  CHECK(shapes.log->cost_us().size() == records.size());
  for (std::size_t k = 1; k < records.size(); ++k) {
    CHECK(records[k].t > records[k - 1].t);
    CHECK(records[k].known >= records[k - 1].known);
    const auto& frames = result.frames;  // each is where the tip was then
    const auto frame = std::ranges::lower_bound(frames, records[k].t - 1e-9, {}, &FrameRecord::t);
    REQUIRE(frame != frames.end());
    CHECK(frame->at == records[k].at);
  }
}

TEST_CASE("the thread keeps pace with a writer that never waits", "[tsan]") {
  const auto body = small_body();
  const State rest = solved(body, Vec3::Zero()), pressed = solved(body, {0, 0.01, 0});
  StateSpace space({.spacing = 0.006, .box = {Vec3::Constant(-0.02), Vec3::Constant(0.02)}});
  std::atomic<std::size_t> made{0};
  std::atomic<std::uint32_t> known{0};
  ShapeLog log(body, {.rate = 200}, [&](const ShapeRecord& record, std::span<const float>) {
    ++made;
    known = record.known;
  });
  const auto begin = std::chrono::steady_clock::now();
  const auto now = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  ShapeThread thread(log, now);
  space.insert(rest);
  const auto goes_on = [&] { return now() < 0.3 || made <= 2 || known < 2; };
  for (int i = 0; goes_on() && now() < 300; ++i) {
    if (i == 50) space.insert(pressed);
    thread.pass({.t = now(), .at = Vec3(0, 0.01 * now(), 0)}, space);
  }
  thread.end();
  CHECK_FALSE(thread.failure());
  CHECK(log.records().size() > 2);
  CHECK(log.known() == 2);
}

TEST_CASE("states without displacements are refused in one line, or end the shapes") {
  const auto body = small_body();
  State bare = solved(body, {0, 0.01, 0});
  bare.displacements = nullptr;
  const std::vector<State> states{solved(body, Vec3::Zero()), bare};
  CHECK_THAT(error_of([&] { check_shapeable(states, *body, "my.states"); }),
             Contains("my.states", "1 of 2 states hold no displacements", "state_space.displacements"));
  SessionInput input = shaped_input();
  input.known = states;
  ShapedRun shapes = shapes_for(input, {.rate = 30});
  CHECK_THROWS_AS(run_session(make_plan(input, virtual_options(0.1)), {}, &shapes), InputError);
  input.known.clear();
  input.touched.displacements = false;
  CHECK_THROWS_AS(run_session(make_plan(input, virtual_options(0.1)), {}, &shapes), InputError);

  StateSpace space({.spacing = 0.006, .box = {Vec3::Constant(-0.02), Vec3::Constant(0.02)}});
  space.insert(bare);
  std::optional<std::string> failure;
  for (int i = 0; i < 100 && !failure; ++i) {  // a thread may be stopped before it begins
    ShapeLog log(body, {.rate = 200});
    ShapeThread thread(log, [] { return 1.0; });
    thread.pass({.t = 1}, space);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    thread.end();
    failure = thread.failure();
  }
  REQUIRE(failure);
  CHECK_THAT(*failure, Contains("shapes ended"));
}

TEST_CASE("options of shapes that make no sense are refused") {
  for (const double rate : {-1.0, 201.0, std::nan("")})
    CHECK_THROWS_AS(check(ShapeOptions{.rate = rate}), InputError);
  CHECK_THROWS_AS(check(ShapeOptions{.rate = 30, .neighbours = 0}), InputError);
  CHECK_NOTHROW(check(ShapeOptions{.rate = 60}));
}

TEST_CASE(
    "of a body touched anywhere: exact in a linear body, at states, and the better the nearer states are") {
  for (const Law law : {Law::linear, Law::neo_hookean}) {
    CAPTURE(law == Law::linear);
    const SessionInput input = test::made_liver(law);
    const auto sites = sites_of(input.touched);
    SiteSolver exact(sites, 0.006, true);
    std::mt19937_64 random(5);
    for (int i = 0; i < 3; ++i) {
      SurfacePlace place = sites->map().random(random);
      while (sites->at(place, false).clamped_share > 0) place = sites->map().random(random);
      const Vec3 inward = -sites->at(place, false).normal, x = 0.012 * inward + Vec3(0.002, -0.001, 0.001);
      const State truth = exact.reference(place, x).state;
      REQUIRE(truth.usable());
      ShapeLog log(input.touched.body, {.rate = 30, .surface = false}, {}, sites);
      const auto error = [&](const Vec3& at) {
        log.take(0, place.at + at, place);
        const Misfit found = misfit(log, log.records().back(), truth);
        return found.error / found.largest;
      };
      const double alone = error(x);
      if (law == Law::linear) CHECK(alone < 1e-5);
      log.learn(exact.reference(place, x + Vec3(0.001, 0.001, 0.002)).state);
      const double beside = error(x);
      log.learn(truth);
      const double at_it = error(x);
      INFO(alone << ' ' << beside << ' ' << at_it);
      CHECK(at_it < 1e-5);
      if (law != Law::linear) CHECK(beside < 0.5 * alone);
    }
  }
}

TEST_CASE("a session that touches a body anywhere has shapes, and the same frames as without") {
  SessionInput input = test::liver();
  const SessionOptions options = test::options_for(PathName::palpation, 0.008, 1.5);
  const SessionResult without = run_session(input, options);
  input.touched.displacements = true;
  ShapedRun shapes{.log = std::make_shared<ShapeLog>(input.touched.body, ShapeOptions{.rate = 20},
                                                     EachShape(), sites_of(input.touched))};
  const SessionResult with = run_session(make_plan(input, options), {}, &shapes);
  CHECK(with.failures.empty());
  REQUIRE(with.frames.size() == without.frames.size());
  for (std::size_t k = 0; k < with.frames.size(); ++k) REQUIRE(with.frames[k].sent == without.frames[k].sent);
  CHECK(shapes.log->records().size() == 30);
  REQUIRE(shapes.checked.size() > 3);
  for (const CheckedShape& checked : shapes.checked) {
    const ShapeRecord& record = shapes.log->records()[checked.record];
    CHECK(record.site.exists());
    INFO((record.at - record.site.at).norm());
    CHECK(checked.error < 0.1);
  }
  const std::size_t free =
      std::ranges::count_if(shapes.log->records(), [](const ShapeRecord& r) { return r.largest == 0; });
  const std::size_t apart =
      std::ranges::count_if(shapes.log->records(), [](const ShapeRecord& r) { return !r.site.exists(); });
  CHECK(free == apart);
}
