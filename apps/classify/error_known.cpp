#include "apps/classify/error_known.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/console/json.hpp"
#include "apps/evaluate/offline_bars.hpp"
#include "apps/scene/scene_tolerance.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/motion/halton.hpp"

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
  return forces && (arguments.bars || (set.spacing_estimated && !arguments.space.spacing));
}

ErrorKnown error_known(const Globals& globals, const ClassifyArguments& arguments, const Classified& set,
                       const std::vector<Vec3>& points) {
  ErrorKnown known;
  known.tolerance = tolerance_of(globals, arguments);
  const EvaluateOptions options{
      .bars = true, .spacing = set.spacing, .checks = set.checks, .checked = set.checked};
  const std::vector<Vec3> places = halton_points(set.box, arguments.bars ? box_places : 1);
  known.box = evaluate(set.states, places, options);
  known.places = places.size();
  for (std::size_t i = 0; i < places.size(); ++i) known.places_within += within(known, known.box, i) ? 1 : 0;
  if (arguments.bars && !points.empty()) known.points = evaluate(set.states, points, options);
  if (!known.box.bars) return known;
  const std::span<const BarSample> samples = known.box.bars->measured->samples();
  std::vector<BarSample> called(samples.begin(), samples.end());
  if (known.box.bars->measured->checked())  // one factor for all, as at the places
    for (BarSample& s : called) s.bar = known.box.bars->measured->at(s.label, s.seen.outside, s.scale);
  known.left_out = known_within(called, known.tolerance);
  known.advice = advise_spacing(samples, known.tolerance, arguments.space.coverage.safe_spread);
  return known;
}

void describe_errors(nlohmann::ordered_json& document, const ClassifyArguments& arguments,
                     const ErrorKnown& found) {
  document["spacing_suggested"] = advice_json(found.advice);
  document["tolerance"] = {{"value", found.tolerance.value}, {"unit", found.tolerance.newtons ? "N" : "1"}};
  if (!arguments.bars) return;
  describe_bars(document, found.points ? found.points->bars : found.box.bars);
  nlohmann::ordered_json& out = document["tolerance"];
  out["places"] = found.places;
  out["within"] = number(double(found.places_within) / double(found.places));
  out["left_out"] = found.left_out.samples;
  out["left_out_called"] = found.left_out.called;
  out["left_out_true"] = found.left_out.called > 0
                             ? number(double(found.left_out.true_ones) / double(found.left_out.called))
                             : nullptr;
  document["known"] = nlohmann::ordered_json::array();
  if (!found.points) {
    for (const char* bar : {"bar90", "bar95", "bar99"}) document[bar] = nlohmann::ordered_json::array();
    return;
  }
  for (std::size_t i = 0; i < found.points->made.forces.size(); ++i)
    document["known"].push_back(within(found, *found.points, i));
}

void tell_errors(const Globals& globals, const ClassifyArguments& arguments, const ErrorKnown& found) {
  if (!arguments.space.spacing) answer(globals, advice_in_words(found.advice, found.tolerance));
  if (!arguments.bars || !found.box.bars) return;
  answer(globals, bars_in_words(found.points && found.points->bars ? *found.points->bars : *found.box.bars));
  std::string text =
      fmt::format("known within {}: {:.1f} % of {} places of the box", in_words(found.tolerance),
                  100 * double(found.places_within) / double(found.places), found.places);
  const KnownWithin& left = found.left_out;
  if (left.called > 0)
    text += fmt::format("; of {} forces {} that count as known so, {:.1f} % are", left.called,
                        found.box.bars->measured->checked() ? "solved as a check" : "left out",
                        100 * double(left.true_ones) / double(left.called));
  answer(globals, text + " (bar of 95 %)");
}

std::string error_cells(const ErrorKnown& found, std::size_t point) {
  return bar_cells(found.points->bars ? found.points->bars->at[point]
                                      : OfflineBars().at(Label::blank, true, 0)) +
         (within(found, *found.points, point) ? ",1" : ",0");
}

std::vector<Declared> declared_errors() {
  std::vector<Declared> rows = declared_bars();
  rows.front().meaning = "with --bars: " + rows.front().meaning;
  rows.push_back({"known", "", "", "with --bars: 1 where bar95 is at most the tolerance, else 0"});
  return rows;
}

std::vector<Declared> declared_errors_json() {
  std::vector<Declared> rows = declared_bars_json();
  for (Declared& row : rows) row.meaning = "with --bars: " + row.meaning;
  const std::vector<Declared> more{
      {"known", "", "", "with --bars: list: whether bar95 of a point is at most the tolerance"},
      {"tolerance.value", "", "", "tolerance of the error: a share of the force, or newtons"},
      {"tolerance.unit", "", "", "1 or N"},
      {"tolerance.within", "1", "",
       "with --bars: share of evenly spread places of the box whose bar95 is at most the tolerance"},
      {"tolerance.places", "1", "", "with --bars: number of these places"},
      {"tolerance.left_out", "1", "", "with --bars: number of comparisons with known forces left out"},
      {"tolerance.left_out_called", "1", "",
       "with --bars: of these, those whose bar95 is at most the tolerance"},
      {"tolerance.left_out_true", "1", "",
       "with --bars: share of those whose error is at most the tolerance"},
      {"spacing_suggested.spacing", "m", "",
       "largest spacing at which 95 % of the forces left out that are safe lie within the tolerance; null: "
       "none"},
      {"spacing_suggested.safe,within", "1", "",
       "number of forces left out that are safe at it, and of these within the tolerance"},
      {"spacing_suggested.wider,wider_within", "1", "",
       "the same for forces that are safe only at a larger spacing, up to 1.5 times"},
      {"spacing_suggested.all", "", "",
       "true: all forces left out are safe at it; a larger one may also hold"}};
  rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}

}  // namespace forefeel
