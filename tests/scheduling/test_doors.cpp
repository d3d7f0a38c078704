// Parts of a session that a user may supply. Each one here wraps a built-in part. Registered under a name or
// given as an object, it must give the same bits as that part.

#include "run_logs.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/generator.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "scheduling/workers/worker_threads.hpp"
#include "small_body.hpp"

namespace {

std::unique_ptr<Device> make_wrapped_path(FactoryContext& with) {
  const double speed = with.arguments.number("speed", 0.06, 1e-3, 1);
  const double tremor = with.arguments.number("tremor", 0, 0, 1e-3);
  return make_device(PathMotion{.path = PathName::tour, .speed = speed, .tremor = tremor}, with);
}

std::unique_ptr<RealWorkers> make_wrapped_threads(RealWorkersContext& with) {
  return std::make_unique<WorkerThreads>(with.body, with.solving);
}

// Registered before main(), in the order that the linker chose.
const bool before_main = (register_device("wrapped-path", make_wrapped_path), true);

// While the program runs.
void register_others() {
  static const bool once = [] {
    register_policy("wrapped-nearest",
                    [](FactoryContext& with) { return make_policy("nearest", {.seed = with.seed}); });
    register_predictor("wrapped-velocity",
                       [](FactoryContext&) { return make_predictor("constant-velocity"); });
    register_cost("wrapped-lognormal", [](FactoryContext& with) {
      return make_cost(LogNormalCost{with.arguments.number("median", 0.02), 0.5}, with, {});
    });
    register_workers("wrapped-threads",
                     {.real = make_wrapped_threads, .simulated = [](VirtualWorkersContext& with) {
                        with.arguments.number("ignored", 0);
                        return make_virtual_workers("threads", with);
                      }});
    return true;
  }();
  REQUIRE(once);
}

SessionOptions built_in_options() {
  SessionOptions options = virtual_options(1.2);
  options.planning.policy = "nearest";
  options.motion.predictor = "constant-velocity";
  options.motion.device = PathMotion{.path = PathName::tour, .speed = 0.05, .tremor = 1e-4};
  options.workers.cost = LogNormalCost{0.03, 0.5};
  options.workers.latency = 0.002;
  options.seed = 4;
  return options;
}

class Runs {
 public:
  std::string logs(const SessionOptions& options, const SessionParts& parts = {}) {
    SessionInput input = small_input();
    input.parts = parts;
    return test::logs(input, options, folder_ / std::to_string(count_++));
  }

 private:
  TemporaryFolder folder_;
  int count_ = 0;
};

}  // namespace

TEST_CASE("parts that are registered under a name are those that they wrap, bit by bit") {
  register_others();
  Runs runs;
  const std::string built_in = runs.logs(built_in_options());
  CHECK(built_in != runs.logs(virtual_options(1.2)));  // the options matter
  const auto same_with = [&](auto&& change) {
    SessionOptions options = built_in_options();
    change(options);
    CHECK(built_in == runs.logs(options));
  };
  same_with([](SessionOptions& o) { o.planning.policy = "wrapped-nearest"; });
  same_with([](SessionOptions& o) { o.motion.predictor = "wrapped-velocity"; });
  same_with([](SessionOptions& o) {
    o.motion.device = Registered("wrapped-path", {{"tremor", "1e-4"}, {"speed", "0.05"}});
  });
  same_with([](SessionOptions& o) {
    o.workers.cost = Registered("wrapped-lognormal", {{"median", "0.03"}});
  });
  same_with([](SessionOptions& o) { o.workers.kind = Registered("wrapped-threads", {{"ignored", "1"}}); });
}

TEST_CASE("parts that are given as objects are those that they wrap, bit by bit") {
  Runs runs;
  const SessionOptions options = built_in_options();
  const std::string built_in = runs.logs(options);
  const SessionInput input = small_input();
  const FactoryContext context{.box = input.touched.space.box, .inward = input.touched.inward, .seed = 4};
  // Names that the objects take the place of.
  SessionOptions others = options;
  others.planning.policy = "fifo";
  CHECK(built_in == runs.logs(others, {.policy = make_policy("nearest", context)}));
  others = options;
  others.motion.predictor = "kalman";
  CHECK(built_in == runs.logs(others, {.predictor = make_predictor("constant-velocity", context)}));
  others = options;
  others.motion.device = PathMotion{};
  CHECK(built_in == runs.logs(others, {.device = make_device(options.motion.device, context)}));
  others = options;
  others.workers.cost = PaperCost{};
  CHECK(built_in == runs.logs(others, {.cost = make_cost(options.workers.cost, context, {})}));

  ReferenceService references(reference_options(input), 1);
  const auto cost = make_cost(options.workers.cost, context, {});
  CHECK(built_in == runs.logs(options, {.virtual_workers = make_virtual_workers(
                                            "threads", {.references = references,
                                                        .cost = *cost,
                                                        .count = options.workers.count,
                                                        .latency = options.workers.latency})}));
}

TEST_CASE("the real clock runs workers of one's own, by name and as an object") {
  register_others();
  for (const bool as_object : {false, true}) {
    SessionInput input = small_input();
    SessionOptions options = virtual_options(2);
    options.clock.kind = Clock::real;
    if (as_object)
      input.parts.workers =
          std::make_shared<WorkerThreads>(input.touched.body, StateSolverOptions{.spacing = 0.006});
    else
      options.workers.kind = "wrapped-threads";
    const SessionResult result = run_session(input, options);
    CHECK(result.frames.size() + result.loop.skipped >= 2000);
    CHECK(result.counts.solved > 0);
  }
}

TEST_CASE("what nobody registered is refused with the names that are") {
  register_others();
  const auto refused = [](auto&& change) {
    SessionOptions options = virtual_options();
    change(options);
    return error_of([&] { make_plan(small_input(), options); });
  };
  CHECK_THAT(refused([](SessionOptions& o) { o.planning.policy = "wrapped"; }),
             Contains("unknown policy 'wrapped', expected one of ", "coverage", "wrapped-nearest",
                      "one that a program registers exists in it alone"));
  CHECK_THAT(refused([](SessionOptions& o) { o.motion.predictor = "wrapped"; }),
             Contains("past, wrapped-velocity"));
  CHECK_THAT(refused([](SessionOptions& o) { o.motion.device = Registered("wrapped"); }),
             Contains("path:NAME, trace:FILE, hand:PROFILE or one of", "wrapped-path"));
  CHECK_THAT(refused([](SessionOptions& o) { o.workers.cost = Registered("wrapped"); }),
             Contains("recorded, paper or one of", "wrapped-lognormal"));
  CHECK_THAT(refused([](SessionOptions& o) { o.workers.kind = "wrapped"; }),
             Contains("threads, wrapped-threads"));
}

TEST_CASE("settings of a registered part are checked against those that its factory reads") {
  const auto refused = [](PartSettings settings) {
    SessionOptions options = virtual_options();
    options.motion.device = Registered("wrapped-path", std::move(settings));
    return error_of([&] { make_plan(small_input(), options); });
  };
  CHECK(refused({{"speed", "0.1"}}).empty());
  CHECK(refused({{"speeed", "0.1"}}) ==
        "device wrapped-path:speeed=0.1: unknown setting 'speeed', expected speed, tremor");
  CHECK(refused({{"speed", "fast"}}) == "device wrapped-path:speed=fast: speed is 'fast', expected a number");
  CHECK(refused({{"speed", "2"}}) == "device wrapped-path:speed=2: speed is 2, expected 0.001 to 1");
  CHECK_THAT(refused({{"speed", "0.1"}, {"speed", "0.2"}}), Contains("'speed' is given twice"));
  CHECK_THAT(refused({{"", "fast"}}), Contains("unknown setting 'fast'"));
}

TEST_CASE("no name is registered twice, none that cannot be written") {
  REQUIRE(before_main);
  register_others();
  const PolicyFactory policy = [](FactoryContext&) { return make_policy("fifo"); };
  CHECK_THAT(error_of([&] { register_policy("coverage", policy); }),
             Contains("'coverage' is registered already"));
  CHECK_THAT(error_of([&] { register_policy("wrapped-nearest", policy); }), Contains("registered already"));
  for (const std::string name : {"", "a b", "a:b", "a,b", "a=b", "\"a\""}) {
    CAPTURE(name);
    CHECK_THAT(error_of([&] { register_policy(name, policy); }), Contains("cannot be a name"));
  }
  CHECK_THAT(error_of([&] { register_device("hand", {}); }), Contains("'hand' is built in"));
  CHECK_THAT(error_of([&] { register_cost("paper", {}); }), Contains("'paper' is built in"));
  CHECK_THAT(error_of([&] {
               register_predictor("kalman", [](FactoryContext&) { return make_predictor("kalman"); });
             }),
             Contains("registered already"));
  CHECK_THAT(error_of([&] { register_workers("none", {}); }), Contains("makes no workers"));
  CHECK_THAT(error_of([&] { register_device("nothing", {}); }), Contains("has no factory"));
}

TEST_CASE("a kind of workers without simulation is refused under the virtual clock") {
  register_workers("only-real", {.real = make_wrapped_threads});
  SessionOptions options = virtual_options();
  options.workers.kind = "only-real";
  CHECK_THAT(error_of([&] { make_plan(small_input(), options); }),
             Contains("has no workers for the virtual clock, expected --clock real"));
  options.clock.kind = Clock::real;
  CHECK_NOTHROW(make_plan(small_input(), options));
}

TEST_CASE("parts are registered and found from several threads at the same time") {
  std::vector<std::jthread> threads;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([i] {
      for (int k = 0; k < 20; ++k) {
        register_cost("parallel-" + std::to_string(i) + "-" + std::to_string(k),
                      [](FactoryContext& with) { return make_cost(PaperCost{}, with, {}); });
        make_cost(Registered("parallel-" + std::to_string(i) + "-0"), {}, {});
        registered_costs();
      }
    });
  threads.clear();
  CHECK(std::ranges::count_if(registered_costs(),
                              [](const std::string& name) { return name.starts_with("parallel-"); }) == 160);
}

TEST_CASE("a rehearsed session refuses objects that can be used once") {
  SessionInput input = small_input();
  SessionOptions options = virtual_options(0.2);
  options.planning.policy = "clairvoyant";
  input.parts.predictor = make_predictor("kalman");
  CHECK_THAT(error_of([&] { make_plan(input, options); }), Contains("register it under a name"));
  input.parts = {.policy = make_policy("clairvoyant-greedy")};
  CHECK_NOTHROW(run_session(input, options));  // a policy object is run as it is
}

namespace {

struct Lost final : Device {  // is nowhere after half a second
  Vec3 position(double t, const Vec3&) noexcept override {
    return t < 0.5 ? Vec3::Zero() : Vec3::Constant(NAN);
  }
  double duration() const override { return 1; }
};

}  // namespace

TEST_CASE("summary and errors name a part given as an object, not the one that the options name", "[doors]") {
  SessionOptions options = built_in_options();
  options.clock.seconds = 0.2;
  SessionInput input = small_input();
  input.parts = {.device = make_device(PathMotion{}, {.box = input.touched.space.box}),
                 .policy = make_policy("fifo")};
  const SessionSummary summary = summarise(run_session(input, options), input, options);
  CHECK(summary.settings.policy == "fifo");
  CHECK(summary.settings.device == "object");

  input.parts.device = std::make_shared<Lost>();
  options.clock.seconds = 1;
  CHECK_THROWS_WITH(make_plan(input, options), Contains("object", "at 0.5 s is not finite"));
}

TEST_CASE("what the factory of a registered part throws names the part") {
  static const bool once = [] {
    register_policy("torn", [](FactoryContext&) -> std::unique_ptr<Policy> {
      throw std::runtime_error("no weights in model.bin");
    });
    register_device("torn", [](FactoryContext& with) -> std::unique_ptr<Device> {
      throw InputError(InputPlace{.file = with.arguments.text("file", "a.csv")}, "is empty");
    });
    register_predictor("torn", [](FactoryContext& with) -> std::unique_ptr<Predictor> {
      with.arguments.number("gain", 1, 0, 2);
      throw 7;
    });
    return true;
  }();
  REQUIRE(once);
  CHECK(error_of([] { make_policy("torn"); }) == "policy torn: its factory failed: no weights in model.bin");
  CHECK(error_of([] {
          make_device(Registered("torn", {{"file", "b.csv"}}), {});
        }) == "device torn:file=b.csv: b.csv: is empty");
  CHECK(error_of([] {
          make_predictor(Registered("torn", {{"gain", "9"}}));
        }) == "predictor torn:gain=9: gain is 9, expected 0 to 2");
  CHECK(error_of([] { make_predictor("torn"); }) ==
        "predictor torn: its factory threw what is no std::exception");
}
