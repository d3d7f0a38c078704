// Sessions that touch a body anywhere: paths over the surface, the loop, states that are solved, the judged error.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "allocation_count.hpp"
#include "scheduling/judge/surface_judge.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/surface_shapes.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/touch/surface_contact.hpp"
#include "tests/support/test.hpp"
#include "touched_liver.hpp"

namespace {

double worst(const SessionResult& result) {
  double worst = 0;
  for (const FrameRecord& frame : result.frames)
    if (std::isfinite(frame.judged.error)) worst = std::max(worst, frame.judged.error);
  return worst;
}

}  // namespace

TEST_CASE("Paths over the surface begin outside, reach their depth and travel outside", "[touch session]") {
  const RestSites& rest = liver_task().field->rest();
  const TouchSurface& surface = *liver_task().surface;
  for (const PathName path : {PathName::line, PathName::raster, PathName::palpation, PathName::tour}) {
    INFO(name(path));
    const PathShape shape = surface_shape({.path = path, .depth = 0.008, .where = ""}, surface, 1);
    REQUIRE(shape.loop.size() > 10);
    CHECK_FALSE(surface.inside(shape.lead.front()));
    double deepest = 0;
    for (const Vec3& tip : shape.loop)
      if (surface.inside(tip)) deepest = std::max(deepest, (tip - rest.map().nearest(tip).at).norm());
    CHECK(deepest > 0.006);
    CHECK(deepest < 0.0081);
  }
  CHECK_THROWS_AS(surface_shape({.path = PathName::circle, .where = ""}, surface, 1), InputError);
}

TEST_CASE("A palpation is rendered within a few per cent, and a virtual run repeats bit by bit",
          "[touch session]") {
  const SessionOptions options = options_for(PathName::palpation, 0.01, 4);
  const SessionResult first = run_session(liver(), options), again = run_session(liver(), options);
  REQUIRE(first.frames.size() == 4000);
  REQUIRE(again.frames.size() == first.frames.size());
  std::size_t touching = 0, compared = 0;
  for (std::size_t i = 0; i < first.frames.size(); ++i) {
    const FrameRecord &a = first.frames[i], &b = again.frames[i];
    REQUIRE(a.force == b.force);
    REQUIRE((a.judged.error == b.judged.error || std::isnan(a.judged.error)));
    touching += a.touch.kind != TouchKind::none;
    compared += std::isfinite(a.judged.error);
    if (a.touch.kind == TouchKind::none) CHECK(a.force.isZero(0));
    CHECK(a.step.change <= a.step.bound * (1 + 1e-9));
  }
  CHECK(touching > 500);
  CHECK(compared > 12);
  CHECK(worst(first) < 0.05);
  for (const std::string& note : first.notes) CHECK_THAT(note, !Contains("reference solves failed"));
}

TEST_CASE("A line with friction slides on the cone, and gains no work", "[touch session]") {
  const SessionInput input = liver_with([](TouchTask& task) { task.friction = 0.3; });
  SessionOptions options = options_for(PathName::line, 0.008, 3);
  options.workers.cost = ConstantCost{1e5};  // no state arrives, so the potential stays
  const SessionResult run = run_session(input, options);
  const FieldOfSites field = input.touched.anywhere->field_of_sites();
  std::size_t slipping = 0;
  double stored = 0, given = 0, lost = 0, most = 0;
  const FrameRecord* before = nullptr;
  for (const FrameRecord& frame : run.frames) {
    lost += frame.touch.lost;
    most = std::max(most, frame.touch.energy);
    if (before) given -= 0.5 * (frame.undamped + before->undamped).dot(frame.at - before->at);
    if (before && frame.touch.kind == TouchKind::slip && before->touch.kind == TouchKind::slip) {
      ++slipping;
      const SurfacePlace& site = before->touch.site;
      const Vec3 way = frame.at - before->at, half_way = 0.5 * (frame.at + before->at) - site.at;
      if (!frame.touch.snaps) {
        CHECK(frame.touch.tip_change ==
              Approx((field.at(site, half_way).at.stiffness * way).norm()).epsilon(0.02).margin(1e-4));
        CHECK(frame.touch.slope == Approx(0.3).epsilon(1e-3));
      }
    }
    before = &frame, stored = frame.touch.energy;
  }
  CHECK(slipping > 500);
  CHECK(lost > 0);
  // What the hand gave is stored or lost. Each frame's work is taken with the force after its slide, so the sum is
  // a little low; exact sums of closed ways are in test_touch.cpp.
  CHECK(most > 0);
  CHECK(std::abs(given - stored - lost) < 0.01 * lost);
  CHECK(worst(run) < 0.1);

  // Frames out of the cone are left out of its exactness, and counted.
  SessionResult marked = run;
  std::size_t touching = 0;
  for (FrameRecord& frame : marked.frames) frame.touch.snaps = false, touching += frame.touch.site.exists();
  for (const std::size_t k : {1000, 1500, 1501, 1502, 1503, 1504}) {
    REQUIRE(marked.frames[k].touch.kind != TouchKind::none);
    marked.frames[k].touch.snaps = true;
  }
  const TouchNumbers counted_touches = touches_of(marked, *input.touched.anywhere);
  CHECK(counted_touches.out_of_cone == Approx(6.0 / static_cast<double>(touching)));
  CHECK(counted_touches.out_of_cone_longest == Approx(0.005));
  CHECK(
      out_of_cone_in_words(counted_touches) ==
      fmt::format("site was out of the cone of friction, catching up, for {:.2g} % of the time in touch, up "
                  "to 0.005 s on end",
                  600.0 / static_cast<double>(touching)));
}

TEST_CASE("What holds a site far from its tip: friction, an edge that is kept, or neither",
          "[touch session]") {
  auto body = std::make_shared<Body>();
  body->mesh = phantom("slab", 600);
  body->material = {Law::linear, 5000, 0.4};
  body->clamp = body->mesh.groups.at("clamp");
  body->pad = Pad{.radius = 0.008, .stiffness = 400};
  TouchTask task;
  task.field = std::make_shared<const SiteField>(std::make_shared<const RestSites>(body, 2),
                                                 SiteFieldOptions{.spacing = 0.03, .threads = 2});
  task.friction = 0.0;
  const SurfaceMap& map = task.field->rest().map();
  const Box box = bounding_box(body->mesh);
  const auto holder_at = [&](const Vec3& at, double slope, bool border = false) {
    SessionResult result;
    FrameRecord frame;
    frame.touch = {.applies = true, .kind = TouchKind::stick, .inside = true, .site = map.nearest(at)};
    frame.touch.slope = slope, frame.touch.at_border = border;
    frame.at = frame.touch.site.at - Vec3(0, 0, 0.05);
    result.frames = {frame};
    CHECK(touches_of(result, task).beyond == 1);
    return touches_of(result, task).holder;
  };
  const Vec3 middle(0.5 * (box.low.x() + box.high.x()), 0.5 * (box.low.y() + box.high.y()), box.high.z());
  const Vec3 rim(box.high.x() - 0.002, middle.y(), box.high.z());
  CHECK(holder_at(middle, 0) == SiteHolder::minimum);
  CHECK(holder_at(rim, 0) == SiteHolder::edge);
  CHECK(holder_at(rim, 0, true) == SiteHolder::clamp);
  task.friction = 0.3;
  CHECK(holder_at(rim, 0.29) == SiteHolder::friction);
  CHECK(holder_at(rim, 0.01) == SiteHolder::edge);
}

TEST_CASE("A bonded site stays, and deep states are solved where the field is not trusted",
          "[touch session]") {
  SessionInput input = liver_with([](TouchTask& task) { task.tolerance = 0.002; });
  const SessionResult run = run_session(input, options_for(PathName::palpation, 0.018, 6));
  std::size_t deep = 0, jets = 0;
  for (const DispatchRecord& d : run.dispatch)
    (d.displacement().isZero(0) ? jets : deep) += d.status == DispatchStatus::solved;
  CHECK(jets > 0);
  CHECK(deep > 0);
  CHECK(run.states.size() == deep + jets);
  bool took = false;
  for (const FrameRecord& frame : run.frames) {
    CHECK(frame.touch.kind != TouchKind::slip);
    took = took || frame.step.took_model;
    CHECK(frame.step.change <= frame.step.bound * (1 + 1e-9));
  }
  CHECK(took);
  input.known = run.states;
  const SessionResult second = run_session(input, options_for(PathName::palpation, 0.018, 6));
  CHECK(second.dispatch.size() < run.dispatch.size());
}

TEST_CASE("A frame of the touch loop allocates nothing, sliding or not", "[touch session]") {
  if (!FOREFEEL_COUNTS_ALLOCATIONS) skip("allocations are not counted under a sanitizer");
  const TouchSurface& surface = *liver_task().surface;
  const auto device = make_device(DeviceSpec(PathMotion{.path = PathName::tour, .depth = 0.008, .where = ""}),
                                  {.box = surface.box(), .seed = 2, .surface = &surface});
  for (const std::optional<double> friction : {std::optional<double>(), std::optional<double>(0.3)}) {
    TouchTask task = liver_task();
    task.friction = friction;
    LoopLink link;
    RenderOptions options;
    options.viscosity = {{.share = 0.3, .time = 0.5}};
    RenderLoop loop(*device, link, options, 3000, {},
                    std::make_unique<SurfaceContact>(task, link, options.switching));
    const SurfaceModel model{.serial = 1, .known = 0, .deep = std::make_shared<const DeepStates>(task.field)};
    link.surfaces.publish(&model);
    const std::size_t before = test::allocations();
    for (std::size_t k = 0; k < 3000; ++k) loop.frame(k, 1e-3 * static_cast<double>(k));
    CHECK(test::allocations() == before);
    std::size_t touching = 0;
    for (const FrameRecord& frame : loop.take_log()) touching += frame.touch.kind != TouchKind::none;
    CHECK(touching > 1000);
  }
}

TEST_CASE("The real clock renders the same path beside workers", "[touch session]") {
  SessionOptions options = options_for(PathName::palpation, 0.01, 2);
  options.clock.kind = Clock::real;
  const SessionResult run = run_session(liver(), options);
  CHECK(run.frames.size() > 1000);
  CHECK_FALSE(run.interrupted());
  CHECK(run.frames.back().sent.isZero(0));
  CHECK(worst(run) < 0.1);
}

TEST_CASE("Error bars hold the tight solves, above a floor that is said", "[touch session]") {
  const SessionOptions options = options_for(PathName::raster, 0.012, 4);
  const SessionResult run = run_session(liver(), options);
  std::size_t samples = 0, inside = 0, above = 0;
  for (const FrameRecord& frame : run.frames) {
    const auto& [at_90, at_95, at_99] = frame.bar.half_width;
    if (frame.touch.kind == TouchKind::none || !std::isfinite(at_95)) continue;
    const double floor = bar_floor(frame.elastic, options.switching);
    CHECK(at_90 >= floor);
    CHECK(at_95 >= at_90);
    CHECK(at_99 >= at_95);
    if (!frame.judged.reference.allFinite()) continue;
    ++samples, above += at_95 > floor;
    inside += (frame.elastic - frame.judged.reference).norm() <= at_95;
  }
  REQUIRE(samples > 30);
  CHECK(above > samples / 4);
  CHECK(inside > 9 * samples / 10);
}

TEST_CASE("Factors of the bars become those of the session's own states", "[touch session]") {
  std::vector<double> scores;
  for (int i = 1; i <= 4000; ++i) scores.push_back(0.001 * i);
  const std::array<double, 3> own = touch_bar_factors(scores), prior = touch_bar_factors({});
  CHECK(own[0] == Approx(3.6).epsilon(0.02));
  CHECK(own[1] == Approx(3.8).epsilon(0.02));
  CHECK(own[2] == Approx(3.96).epsilon(0.02));
  CHECK(prior[0] < prior[1]);
  CHECK(prior[1] < prior[2]);
}

TEST_CASE("A tip that drags its site along says so first, one that slides does not", "[touch session]") {
  SessionOptions options = options_for(PathName::line, 0.008, 4);
  options.workers.cost = ConstantCost{1e5};
  for (const bool bonded : {true, false}) {
    const SessionInput input = liver_with([&](TouchTask& task) {
      task.depth = 0.012;
      if (!bonded) task.friction = usual_friction;
    });
    const SessionResult run = run_session(input, options);
    std::size_t touching = 0, beyond = 0;
    for (const FrameRecord& frame : run.frames)
      if (frame.touch.kind != TouchKind::none)
        ++touching, beyond += (frame.at - frame.touch.site.at).norm() > std::hypot(0.012, 0.006);
    const SessionSummary summary = summarise(run, input, options);
    REQUIRE(summary.motion.touch);
    CHECK(summary.motion.touch->beyond == Approx(double(beyond) / double(touching)));
    const std::vector<std::string> lines = attention(summary);
    const std::string first = lines.empty() ? "" : lines.front();
    const std::string said = fmt::format("than any state is placed for {:.2g} % of the time in touch",
                                         100 * double(beyond) / double(touching));
    if (bonded)
      CHECK_THAT(first, Contains(said, "contact.bonded = true"));
    else
      CHECK_THAT(first, !Contains("than any state is placed"));
  }
}

TEST_CASE("What is for one place is refused", "[touch session]") {
  SessionOptions options = options_for(PathName::palpation, 0.01, 1);
  options.switching.rule = SwitchRule::paper;
  CHECK_THROWS_WITH(run_session(liver(), options), Contains("session.switch"));
  options = options_for(PathName::press, 0.01, 1);
  CHECK_THROWS_WITH(run_session(liver(), options), Contains("palpation"));
}
