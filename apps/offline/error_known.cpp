#include "apps/offline/error_known.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/offline/offline_bars.hpp"
#include "apps/scene/scene_spacing.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/halton.hpp"

namespace forefeel {
namespace {

constexpr std::size_t box_places = 300;

bool within(const ErrorKnown& known, const Evaluation& found, std::size_t i) {
  return found.bars && found.bars->at[i][1] <= known.tolerance.limit(found.made.forces[i].norm());
}

}  // namespace

Tolerance tolerance_of(const Globals& globals, const ClassifyArguments& arguments) {
  if (!arguments.tolerance.empty()) {
    const std::optional<Tolerance> given = tolerance_from(arguments.tolerance);
    if (!given)
      throw InputError("--tolerance",
                       fmt::format("is '{}', expected a share of the force as 0.07, or a force as "
                                   "\"0.07 N\", above 0",
                                   arguments.tolerance));
    return *given;
  }
  if (!arguments.input.scene.empty())
    if (const std::optional<Tolerance> written = written_tolerance(arguments.input.scene, globals.set))
      return *written;
  return {};
}

bool wants_errors(const ClassifyArguments& arguments, const Classified& set) {
  const bool forces = std::ranges::any_of(
      set.states, [](const State& s) { return s.force.allFinite() && !s.force.isZero(0); });
  if (arguments.bars && !forces)
    throw InputError("--bars", "needs forces, expected states that are not all without one");
  return forces && (arguments.bars || (set.estimated_dimension > 0 && !arguments.space.spacing));
}

ErrorKnown error_known(const Globals& globals, const ClassifyArguments& arguments, const Classified& set,
                       const std::vector<Vec3>& points) {
  ErrorKnown known;
  known.tolerance = tolerance_of(globals, arguments);
  Progress progress(globals, "classify");
  EvaluateOptions options{
      .bars = true, .spacing = set.spacing, .noise = arguments.noise, .checks = set.checks};
  options.show = stages_of(progress, "classify, error bars");
  std::vector<Vec3> places = halton_points(set.box, arguments.bars ? box_places : 1);
  for (Vec3& place : places) place = set.turn.transpose() * place;
  known.box = evaluate(set.states, places, options);
  known.places = places.size();
  options.field = known.box.field;
  for (std::size_t i = 0; i < places.size(); ++i) known.places_within += within(known, known.box, i) ? 1 : 0;
  if (arguments.bars && !points.empty()) known.points = evaluate(set.states, points, options);
  if (!known.box.bars) return known;
  const std::span<const BarSample> samples = known.box.bars->measured->samples();
  std::vector<BarSample> called(samples.begin(), samples.end());
  if (known.box.bars->measured->checked())  // one factor for all, as at the places
    for (BarSample& s : called)
      s.bar = known.box.bars->measured->at({.label = s.label, .outside = s.seen.outside, .scale = s.scale});
  known.left_out = known_within(called, known.tolerance);
  known.advice = advise_spacing(samples, known.tolerance, arguments.space.coverage.safe_spread);
  return known;
}

namespace {

using E = ErrorShown;

Json left_out_true(const KnownWithin& left) {
  return left.called > 0 ? number(double(left.true_ones) / double(left.called)) : Json();
}

// Whether each point is known within the tolerance.
Json points_known(const E& e) {
  Json list = Json::array();
  if (e.found.points)
    for (std::size_t i = 0; i < e.found.points->made.forces.size(); ++i)
      list.push_back(within(e.found, *e.found.points, i));
  return list;
}

// These only with --bars.
template <class Get>
auto with_bars(Get get) {
  return [get](const E& e) { return e.bars ? std::optional(get(e.found)) : std::nullopt; };
}

JsonKey<E> bars_part() {
  std::vector<Declared> rows = declared(bar_keys());
  for (Declared& row : rows) row.meaning = "with --bars: " + row.meaning;
  return {
      std::move(rows), [](Json& document, const E& e) {
        if (!e.bars) return;
        const std::optional<EvaluatedBars>& bars = e.found.points ? e.found.points->bars : e.found.box.bars;
        add_to(document, bar_keys(), {.bars = bars ? &*bars : nullptr, .points = e.found.points.has_value()});
      }};
}

}  // namespace

const JsonKeys<ErrorShown>& error_keys() {
  using K = ErrorKnown;
  static const JsonKeys<E> keys{
      json_object<E>("spacing_suggested", advice_keys(), "", [](const E& e) { return &e.found.advice; }),
      {"tolerance.value", "", "tolerance of the error: a share of the force, or newtons",
       [](const E& e) { return e.found.tolerance.value; }},
      {"tolerance.unit", "", "1 or N", [](const E& e) { return e.found.tolerance.newtons ? "N" : "1"; }},
      bars_part(),
      {"tolerance.places", "1", "with --bars: number of evenly spread places of the box",
       with_bars([](const K& k) { return k.places; })},
      {"tolerance.within", "1", "with --bars: share of these places whose bar95 is at most the tolerance",
       with_bars([](const K& k) { return double(k.places_within) / double(k.places); })},
      {"tolerance.left_out", "1", "with --bars: number of comparisons with known forces left out",
       with_bars([](const K& k) { return k.left_out.samples; })},
      {"tolerance.left_out_called", "1", "with --bars: of these, those whose bar95 is at most the tolerance",
       with_bars([](const K& k) { return k.left_out.called; })},
      {"tolerance.left_out_true", "1", "with --bars: share of those whose error is at most the tolerance",
       with_bars([](const K& k) { return left_out_true(k.left_out); })},
      {"known", "", "with --bars: list: whether bar95 of a point is at most the tolerance",
       [](const E& e) { return e.bars ? std::optional(points_known(e)) : std::nullopt; }}};
  return keys;
}

void tell_errors(const Globals& globals, const ClassifyArguments& arguments, const ErrorKnown& found) {
  if (!arguments.space.spacing) answer(globals, advice_in_words(found.advice, found.tolerance));
  if (!arguments.bars || !found.box.bars) return;
  answer(globals, bars_in_words(found.points && found.points->bars ? *found.points->bars : *found.box.bars));
  std::string text =
      fmt::format("known within {}: {:.1f} % of {} of the box", in_words(found.tolerance),
                  100 * double(found.places_within) / double(found.places), counted(found.places, "place"));
  const KnownWithin& left = found.left_out;
  if (left.called > 0)
    text += fmt::format("; of {} forces {} that count as known so, {:.1f} % are", left.called,
                        found.box.bars->measured->checked() ? "solved as a check" : "left out",
                        100 * double(left.true_ones) / double(left.called));
  answer(globals, text + " (bar of 95 %)");
}

BarWidths bar_of(const ErrorKnown& found, std::size_t point) {
  return found.points->bars ? found.points->bars->at[point] : unknown_factors();
}

bool is_known(const ErrorKnown& found, std::size_t point) {
  return within(found, *found.points, point);
}

}  // namespace forefeel
