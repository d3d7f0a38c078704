#include "run_logs.hpp"
#include "scheduling/judge/session_judge.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/session/virtual_run.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "small_body.hpp"

TEST_CASE("virtual clock: same seed, same bytes, whatever the threads") {
  const TemporaryFolder folder;
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
      run_session(input, options, {.each_position = [&](const Vec3& at) { positions.push_back(at); }});
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
  struct Answering final : Device {  // claims to depend on the force, but does not
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
      RunSetup setup = divide(plan, references);
      setup.solving.cost =
          make_cost(LogNormalCost{0.03, 0.8}, {.seed = 3}, [&] { return references.recorded_costs(); });
      FramePipeline pipeline(input.touched.space);
      std::shared_ptr<FollowingRenderer> renderer;
      if (!in_turn) {
        renderer = std::make_shared<FollowingRenderer>(pipeline.known(), setup.rendering, frames);
        pipeline.add(renderer);
      }
      const auto judge = std::make_shared<SessionJudge>(setup.judging, pipeline.known(), references);
      pipeline.add(judge);
      SessionResult result;
      run_virtual(setup, {references, pipeline, renderer.get()}, result, {});
      pipeline.pass_rest(result.frames, result.states);
      pipeline.wait();
      judge->finish(result, {});
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
        REQUIRE((a.label == b.label && a.step.model == b.step.model && a.known == b.known &&
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
