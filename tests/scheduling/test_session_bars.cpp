// Error bars of a whole session, against tight solves.

#include "scheduling/record/summary.hpp"
#include "scheduling/session/session.hpp"
#include "tests/scheduling/small_body.hpp"

namespace {

SessionOptions audited(double share) {
  SessionOptions options = virtual_options(4);
  options.planning.audit = share;
  options.workers.cost = ConstantCost{0.05};
  return options;
}

std::size_t audits_in(const SessionResult& result) {
  return static_cast<std::size_t>(
      std::ranges::count_if(result.dispatch, [](const DispatchRecord& d) { return d.choice.audit; }));
}

}  // namespace

TEST_CASE("error bars: every frame of a model with states has them, the wider level the wider bar") {
  const SessionResult r = run_session(small_input(), audited(0.2));
  std::size_t with = 0;
  for (const FrameRecord& f : r.frames) {
    const auto& [at_90, at_95, at_99] = f.bar.half_width;
    if (!std::isfinite(at_90)) continue;
    ++with;
    const double held = (f.elastic - f.undamped).norm();  // known, so the half-width is at least this
    REQUIRE(at_90 >= held);
    REQUIRE(at_95 >= at_90);
    REQUIRE(at_99 >= at_95);
  }
  CHECK(with > r.frames.size() / 2);
}

TEST_CASE("error bars: the truth is inside as often as they say, within what the samples can show") {
  const SessionOptions options = audited(0.1);
  for (const Law law : {Law::neo_hookean, Law::st_venant_kirchhoff}) {
    const SessionInput input = small_input(law);
    const SessionResult r = run_session(input, options);
    const SessionSummary summary = summarise(r, input, options);
    const SessionSummary::Bars& bars = summary.error.bars.all;
    CAPTURE(bars.samples, bars.inside[0], bars.inside[1], bars.inside[2]);
    REQUIRE(bars.samples >= 40);
    // Samples follow each other along the path and are not independent: 10 points is about 3 standard errors.
    CHECK(bars.inside[0] >= 0.80);
    CHECK(bars.inside[1] >= 0.85);
    CHECK(bars.inside[2] >= 0.89);
    CHECK(bars.inside[0] <= bars.inside[1]);
    CHECK(bars.inside[1] <= bars.inside[2]);
    CHECK(bars.width_p50 > 0);
  }
}

TEST_CASE("audits: the asked share of the solves, where the tip was, none where none is asked for") {
  CHECK(audits_in(run_session(small_input(), audited(0))) == 0);
  const SessionResult r = run_session(small_input(), audited(0.3));
  const double share = static_cast<double>(audits_in(r)) / static_cast<double>(r.dispatch.size());
  CHECK(share > 0.05);
  CHECK(share < 0.45);
  for (const DispatchRecord& d : r.dispatch) {
    if (!d.choice.audit) continue;
    CHECK(std::ranges::any_of(r.frames, [&](const FrameRecord& f) { return f.at == d.at; }));
  }
}

TEST_CASE("error bars: the same inputs and seed give the same bars") {
  const SessionResult a = run_session(small_input(), audited(0.1));
  const SessionResult b = run_session(small_input(), audited(0.1));
  REQUIRE(a.frames.size() == b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    REQUIRE(a.frames[i].force == b.frames[i].force);
    REQUIRE(a.frames[i].bar.half_width == b.frames[i].bar.half_width);
  }
}

TEST_CASE("error bars: none is finer than a tenth of the JND, and samples at that floor are counted apart") {
  const SessionInput input = small_input();
  SessionOptions options = audited(0.1);
  options.switching.jnd_floor = 0.2;
  const SessionResult r = run_session(input, options);
  const SessionSummary::ErrorBars bars = summarise(r, input, options).error.bars;
  std::size_t floored = 0, above = 0, inside = 0;
  for (const FrameRecord& f : r.frames) {
    const double floor = std::max(0.02, 0.007 * f.force.norm()), bar = f.bar.half_width[1];
    if (!std::isfinite(bar)) continue;
    REQUIRE(bar >= floor * (1 - 1e-12));
    if (!f.judged.sampled || !std::isfinite(f.judged.error)) continue;
    const bool at_floor = bar < floor * (1 + 1e-6);
    floored += at_floor ? 1 : 0;
    above += at_floor ? 0 : 1;
    inside += !at_floor && (f.force - f.judged.reference).norm() <= bar ? 1 : 0;
  }
  CHECK(floored > 0);
  CHECK(bars.at_floor[1] == floored);
  REQUIRE(above > 0);
  CHECK(bars.inside_above[1] == Approx(double(inside) / double(above)));
  CHECK(bars.at_floor[0] >= bars.at_floor[1]);
  CHECK(bars.at_floor[1] + above == bars.all.samples);
}

TEST_CASE("error bars: they are wider while few states are known") {
  SessionOptions options = audited(0);
  options.workers.cost = ConstantCost{0.2};
  const SessionResult r = run_session(small_input(), options);
  // Where one state is known, the curvature c is taken as 0.1 |K| / h; the bar is ten times as wide.
  double one = 0, many = 0;
  for (const FrameRecord& f : r.frames) {
    if (!std::isfinite(f.bar.scale) || f.at.norm() < 1e-4) continue;
    if (f.known == 1) one = std::max(one, f.bar.scale);
    if (f.known > 8) many = std::max(many, f.bar.scale);
  }
  REQUIRE(one > 0);
  REQUIRE(many > 0);
  CHECK(one > many);
}
