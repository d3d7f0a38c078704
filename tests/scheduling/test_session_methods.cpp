#include "scheduling/session/session.hpp"
#include "small_body.hpp"

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
    CHECK(std::ranges::any_of(r.notes, [](const std::string& note) {
      return note.find("frames no full lattice cell of known states was about the tip") != std::string::npos;
    }));
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
  // States being solved keep free positions away, like known states.
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
