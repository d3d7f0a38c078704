// Sessions and placements with models of energy jets, on a beam of a few tetrahedra; truth by tight solves.

#include "geometry/states/energy_jet.hpp"
#include "scheduling/placement/placement.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/session/session.hpp"
#include "small_body.hpp"
#include "solver/equilibrium/solver.hpp"

namespace {

SessionOptions jet_options(double seconds, double speed, const char* policy = "error") {
  SessionOptions options = virtual_options(seconds);
  options.model.fit = {.data = Data::jet, .neighbours = 8};
  options.planning.policy = Registered(policy);
  options.motion.device = PathMotion{.path = PathName::lissajous, .speed = speed};
  options.workers.count = 2;
  options.workers.cost = ConstantCost{0.05};
  return options;
}

}  // namespace

TEST_CASE("With jets the state at rest is there before the loop, and the first frames are its jet",
          "[jets]") {
  const SessionResult r = run_session(small_input(), jet_options(1.0, 0.05, "coverage"));
  REQUIRE(r.frames.size() == 1000);
  CHECK(r.counts.start == 1);
  CHECK(r.frames.front().known == 1);
  REQUIRE(r.states.size() > 1);
  CHECK(r.states[0].at == Vec3::Zero());
  for (const State& s : r.states) {
    REQUIRE(s.jet);
    CHECK(s.jet->order == most_jet_order);
  }
  const EnergyJet& rest = *r.states[0].jet;
  std::size_t alone = 0;
  for (const FrameRecord& f : r.frames) {
    REQUIRE(f.step.change <= f.step.bound);
    if (f.known > 1) continue;
    ++alone;
    const Vec3 expected = -(r.states[0].stiffness * f.at + jet_terms(rest, f.at).gradient);
    CHECK((f.undamped - expected).norm() <= 1e-9 * (1 + expected.norm()));
  }
  CHECK(alone >= 20);
  const SessionSummary s = summarise(r, small_input(), jet_options(1.0, 0.05, "coverage"));
  CHECK(s.error.time_trusted > 0);
  CHECK(s.error.by_trust[0].samples + s.error.by_trust[1].samples == s.error.samples.samples);
  if (s.error.by_trust[1].samples > 0) CHECK(s.error.by_trust[1].p95 < 0.07);
}

TEST_CASE("Workers stay idle while no error is estimated above the JND, and a note says so", "[jets]") {
  SessionOptions options = jet_options(1.0, 0.01);
  SessionInput input = small_input(Law::linear);  // the jet at rest is the whole truth
  const SessionResult r = run_session(input, options);
  CHECK(r.counts.solved == 0);
  CHECK(std::ranges::any_of(r.notes,
                            [](const std::string& n) { return n.starts_with("workers stayed idle"); }));
  for (const FrameRecord& f : r.frames) CHECK(f.bar.trusted);
  CHECK(summarise(r, input, options).error.samples.max < 1e-6);
}

TEST_CASE("The same session of jets twice gives the same bits", "[jets]") {
  const SessionResult a = run_session(small_input(), jet_options(0.5, 0.1)),
                      b = run_session(small_input(), jet_options(0.5, 0.1));
  REQUIRE(a.frames.size() == b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    CHECK(a.frames[i].force == b.frames[i].force);
    CHECK(a.frames[i].bar.trusted == b.frames[i].bar.trusted);
  }
}

TEST_CASE("Placement with jets needs fewer states, and its error holds at tight solves", "[jets]") {
  const SessionInput input = small_input();
  std::array<std::size_t, 2> needed{};
  for (const Data data : {Data::jet, Data::force_and_stiffness}) {
    PlacementOptions options;
    options.error = 0.02;
    options.space = input.touched.space;
    options.truth_samples = 40;
    options.threads = 1;
    options.estimate.model = {.kernel = Kernel::quintic, .data = data, .neighbours = usual_neighbours(data)};
    std::vector<State> states;
    const PlacementReport report = place_states(
        input.touched.body, options, {}, [&](State s) { states.push_back(std::move(s)); },
        [](const PlacementProgress&) {});
    REQUIRE(report.truth.holds);
    needed[data == Data::jet ? 0 : 1] = report.states;
    StateSpace space(input.touched.space);
    for (const State& s : states)
      if (s.usable()) space.insert(s);
    ErrorEstimator estimator(space, options.estimate);
    Solver solver(input.touched.body);
    std::vector<State> truth;
    for (std::uint64_t i = 0; i < 60; ++i) {
      const Box& box = input.touched.space.box;
      const double share = static_cast<double>(i) / 60;
      const Vec3 at =
          box.low + box.size().cwiseProduct(Vec3(share, std::fmod(7 * share, 1), std::fmod(13 * share, 1)));
      truth.push_back(solver.reference(at, 0.006).state);
    }
    CHECK(true_error(estimator, truth, options.estimate.floor).held() < 0.03);
  }
  CHECK(2 * needed[0] <= needed[1] + 1);
}
