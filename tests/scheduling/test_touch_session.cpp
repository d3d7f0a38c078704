// Sessions that touch a body anywhere: paths over the surface, the loop, states that are solved, the judged error.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "allocation_count.hpp"
#include "geometry/common/error.hpp"
#include "geometry/meshing/phantom.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/surface_shapes.hpp"
#include "scheduling/touch/touch_judge.hpp"
#include "scheduling/touch/touch_loop.hpp"
#include "scheduling/touch/touch_session.hpp"
#include "solver/body/pad.hpp"
#include "tests/support/skip.hpp"

namespace forefeel {
namespace {

DrawPlaces draw_from(const RestSites& rest) {
  return [&rest](const std::string&, std::size_t count, std::uint64_t seed) {
    std::mt19937_64 random(seed + 1);
    std::vector<SurfacePlace> places;
    while (places.size() < count)
      if (const SurfacePlace place = rest.map().random(random); !(rest.at(place, false).clamped_share > 0))
        places.push_back(place);
    return places;
  };
}

TouchSessionInput made_liver(Law law) {
  auto body = std::make_shared<Body>();
  body->mesh = phantom("liver", 600);
  body->material = {law, 5000, 0.4};
  body->clamp = body->mesh.groups.at("clamp");
  body->pad = Pad{};
  const auto field = std::make_shared<const SiteField>(std::make_shared<const RestSites>(body, 2),
                                                       SiteFieldOptions{.spacing = 0.015, .threads = 2});
  TouchSessionInput input;
  input.task.field = field;
  input.task.grid = std::make_shared<const SurfaceGrid>(field->rest().map());
  input.task.patches = std::make_shared<const FieldPatches>(field);
  input.task.tips.box = {Vec3::Constant(1), Vec3::Constant(-1)};
  for (const Vec3& node : body->mesh.nodes)
    input.task.tips.box.low = input.task.tips.box.low.cwiseMin(node),
    input.task.tips.box.high = input.task.tips.box.high.cwiseMax(node);
  input.site_spacing = 0.015;
  input.draw = draw_from(field->rest());
  return input;
}

const TouchSessionInput& liver() {
  static const TouchSessionInput input = made_liver(Law::neo_hookean);
  return input;
}

SessionOptions options_for(PathName path, double depth, double seconds) {
  SessionOptions options;
  options.clock = {.kind = Clock::virtual_time, .seconds = seconds};
  options.motion.device = DeviceSpec(PathMotion{.path = path, .depth = depth, .where = ""});
  options.workers.count = 2;
  options.seed = 3;
  options.judging.reference_step = 0.004;
  options.judging.visit_stride = 4;
  options.workers.threads = 2;
  return options;
}

double worst(const TouchSessionResult& result) {
  double worst = 0;
  for (const TouchFrameRecord& frame : result.frames)
    if (std::isfinite(frame.judged.error)) worst = std::max(worst, frame.judged.error);
  return worst;
}

}  // namespace

TEST_CASE("Paths over the surface begin outside, reach their depth and travel outside", "[touch session]") {
  const RestSites& rest = liver().task.field->rest();
  const SessionSurface surface(rest, *liver().task.grid, 0.02, liver().draw);
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
  const TouchSessionResult first = run_touch_session(liver(), options),
                           again = run_touch_session(liver(), options);
  REQUIRE(first.frames.size() == 4000);
  REQUIRE(again.frames.size() == first.frames.size());
  std::size_t touching = 0, compared = 0;
  for (std::size_t i = 0; i < first.frames.size(); ++i) {
    const TouchFrameRecord &a = first.frames[i], &b = again.frames[i];
    REQUIRE(a.force.rendered == b.force.rendered);
    REQUIRE((a.judged.error == b.judged.error || std::isnan(a.judged.error)));
    touching += a.touch != TouchKind::none;
    compared += std::isfinite(a.judged.error);
    if (a.touch == TouchKind::none) CHECK(a.force.rendered.isZero(0));
    CHECK(a.step.change <= a.step.bound * (1 + 1e-9));
  }
  CHECK(touching > 500);
  CHECK(compared > 12);
  CHECK(worst(first) < 0.05);
  CHECK(first.references_failed == 0);
}

TEST_CASE("A line with friction slides on the cone, and gains no work", "[touch session]") {
  TouchSessionInput input = liver();
  input.task.friction = 0.3;
  SessionOptions options = options_for(PathName::line, 0.008, 3);
  options.workers.cost = ConstantCost{1e5};  // no state arrives, so the potential stays
  const TouchSessionResult run = run_touch_session(input, options);
  std::size_t slipping = 0;
  double stored = 0, given = 0, lost = 0, most = 0;
  const TouchFrameRecord* before = nullptr;
  for (const TouchFrameRecord& frame : run.frames) {
    lost += frame.lost;
    most = std::max(most, frame.energy);
    if (before) given -= 0.5 * (frame.force.undamped + before->force.undamped).dot(frame.tip - before->tip);
    if (before && frame.touch == TouchKind::slip && before->touch == TouchKind::slip) {
      ++slipping;
      // On an edge a site may stop although another part's force would drive it on.
      if (!input.task.patches->is_on_edge(frame.site)) CHECK(frame.source.slope == Approx(0.3).epsilon(1e-3));
    }
    before = &frame, stored = frame.energy;
  }
  CHECK(slipping > 500);
  CHECK(lost > 0);
  // What the hand gave is stored or lost. Each frame's work is taken with the force after its slide, so the sum is
  // a little low; exact sums of closed ways are in test_touch.cpp.
  CHECK(most > 0);
  CHECK(std::abs(given - stored - lost) < 0.01 * lost);
  CHECK(worst(run) < 0.1);
}

TEST_CASE("Without friction the site stays, and deep states are solved where the field is not trusted",
          "[touch session]") {
  TouchSessionInput input = liver();
  input.task.tolerance = 0.002;
  const TouchSessionResult run = run_touch_session(input, options_for(PathName::palpation, 0.018, 6));
  std::size_t deep = 0, jets = 0;
  for (const TouchDispatch& d : run.dispatches)
    (d.x.isZero(0) ? jets : deep) += d.status == DispatchStatus::solved;
  CHECK(jets > 0);
  CHECK(deep > 0);
  CHECK(run.states.size() == deep + jets);
  bool took = false;
  for (const TouchFrameRecord& frame : run.frames) {
    CHECK(frame.touch != TouchKind::slip);
    took = took || frame.step.took_model;
    CHECK(frame.step.change <= frame.step.bound * (1 + 1e-9));
  }
  CHECK(took);
  TouchSessionInput knowing = input;
  knowing.known = run.states;
  const TouchSessionResult second = run_touch_session(knowing, options_for(PathName::palpation, 0.018, 6));
  CHECK(second.dispatches.size() < run.dispatches.size());
}

TEST_CASE("A frame of the touch loop allocates nothing, sliding or not", "[touch session]") {
  if (!FOREFEEL_COUNTS_ALLOCATIONS) test::skip("allocations are not counted under a sanitizer");
  const SessionSurface surface(liver().task.field->rest(), *liver().task.grid, 0.02, liver().draw);
  const auto device = make_device(DeviceSpec(PathMotion{.path = PathName::tour, .depth = 0.008, .where = ""}),
                                  {.box = surface.box(), .seed = 2, .surface = &surface});
  for (const std::optional<double> friction : {std::optional<double>(), std::optional<double>(0.3)}) {
    FieldOfSites field(liver().task.field, liver().task.grid, farthest_of(0.025), liver().task.patches);
    TouchLink link;
    TouchLoopOptions options;
    options.friction = friction;
    options.render.viscosity = {{.share = 0.3, .time = 0.5}};
    TouchLoop loop(*device, field, link, options, 3000);
    TouchModel model{.serial = 1, .known = 0, .deep = std::make_shared<const DeepStates>(liver().task.field)};
    link.models.publish(&model);
    const std::size_t before = testing::allocations();
    for (std::size_t k = 0; k < 3000; ++k) loop.frame(k, 1e-3 * static_cast<double>(k));
    CHECK(testing::allocations() == before);
    std::size_t touching = 0;
    for (const TouchFrameRecord& frame : loop.take_log()) touching += frame.touch != TouchKind::none;
    CHECK(touching > 1000);
  }
}

TEST_CASE("The real clock renders the same path beside workers", "[touch session]") {
  SessionOptions options = options_for(PathName::palpation, 0.01, 2);
  options.clock.kind = Clock::real;
  const TouchSessionResult run = run_touch_session(liver(), options);
  CHECK(run.frames.size() > 1000);
  CHECK_FALSE(run.interrupted);
  CHECK(run.frames.back().force.sent.isZero(0));
  CHECK(worst(run) < 0.1);
}

TEST_CASE("Error bars hold the tight solves, above a floor that is said", "[touch session]") {
  const SessionOptions options = options_for(PathName::raster, 0.012, 4);
  const TouchSessionResult run = run_touch_session(liver(), options);
  std::size_t samples = 0, inside = 0, above = 0;
  for (const TouchFrameRecord& frame : run.frames) {
    const auto& [at_90, at_95, at_99] = frame.source.bar.half_width;
    if (frame.touch == TouchKind::none || !std::isfinite(at_95)) continue;
    const double floor = touch_bar_floor(frame, options.switching);
    CHECK(at_90 >= floor);
    CHECK(at_95 >= at_90);
    CHECK(at_99 >= at_95);
    if (!frame.judged.reference.allFinite()) continue;
    ++samples, above += at_95 > floor;
    inside += (frame.force.elastic - frame.judged.reference).norm() <= at_95;
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

TEST_CASE("What is for one place is refused", "[touch session]") {
  SessionOptions options = options_for(PathName::palpation, 0.01, 1);
  options.switching.rule = SwitchRule::paper;
  CHECK_THROWS_WITH(run_touch_session(liver(), options), Catch::Contains("session.switch"));
  options = options_for(PathName::press, 0.01, 1);
  CHECK_THROWS_WITH(run_touch_session(liver(), options), Catch::Contains("palpation"));
}

}  // namespace forefeel
