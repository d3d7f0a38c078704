#include "apps/offline/offline_bars.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "apps/console/json.hpp"
#include "apps/console/outputs.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/coverage/coverage.hpp"
#include "geometry/mesh/vtu_writer.hpp"

namespace forefeel {
namespace {

constexpr const char* level_names[] = {"90", "95", "99"};
constexpr double fewer = 0.05;   // a share that is further below its level gives a warning
constexpr std::size_t few = 30;  // with fewer forces, the share of a label is not printed

Json cover_json(const BarCover& cover) {
  Json out;
  out["samples"] = cover.samples;
  for (std::size_t i = 0; i < bar_levels.size(); ++i)
    out["coverage"][fmt::format("p{}", level_names[i])] = number(cover.inside[i]);
  out["width_p50"] = number(cover.width_p50);
  return out;
}

std::string share(double inside) {
  return std::isfinite(inside) ? fmt::format("{:.1f}", 100 * inside) : "?";
}

std::string shares(const BarCover& cover) {
  return fmt::format("{}/{}/{} %", share(cover.inside[0]), share(cover.inside[1]), share(cover.inside[2]));
}

bool too_few_inside(const BarCover& cover) {
  for (std::size_t i = 0; i < bar_levels.size(); ++i)
    if (cover.inside[i] < bar_levels[i] - fewer) return true;
  return false;
}

// The coverage of bars, as three keys of T. cover: of T, a BarCover.
template <class Get>
JsonKeys<EvaluatedBars> cover_keys(const std::string& before, const std::string& samples,
                                   const std::string& coverage, Get cover) {
  using B = EvaluatedBars;
  return {{before + "samples", "1", samples, [=](const B& b) { return cover(b).samples; }},
          {before + "coverage.p90,p95,p99", "1", coverage,
           [=](const B& b) {
             const auto& [p90, p95, p99] = cover(b).inside;
             return json_numbers({p90, p95, p99});
           }},
          {before + "width_p50", "N", "median half-width of 95 % of their bars",
           [=](const B& b) { return cover(b).width_p50; }}};
}

Json cover_by_label(const EvaluatedBars& bars) {
  Json out;
  for (const Label label : all_labels)
    out[std::string(name(label))] = cover_json(bars.measured->cover(label));
  return out;
}

const JsonKeys<EvaluatedBars>& error_bar_keys() {
  using B = EvaluatedBars;
  static const JsonKeys<B> keys = [] {
    JsonKeys<B> all = cover_keys("",
                                 "number of comparisons with known forces, left out in groups of "
                                 "neighbouring positions; a force on the "
                                 "border may be left out more than once",
                                 "share of them inside their bars, each bar from the other groups",
                                 [](const B& b) { return b.measured->cover(); });
    const JsonKeys<B> more{
        {"levels", "1", "list: the levels of coverage", [](const B&) { return bar_levels; }},
        {"beyond", "1",
         "points farther from the states than any force left out; compared apart inside and outside the "
         "states",
         &B::beyond},
        {"checked", "",
         "true: within their box, the bars come from the check solves of generate --error, not from forces "
         "left "
         "out",
         [](const B& b) { return b.measured->checked(); }},
        {"points_outside", "1", "points outside the states", &B::outside}};
    const JsonKeys<B> outside = cover_keys(
        "outside.", "number of the forces left out that lie outside the other states",
        "share of these inside their bars", [](const B& b) { return b.measured->cover_outside(); });
    all.insert(all.end(), more.begin(), more.end());
    all.insert(all.end(), outside.begin(), outside.end());
    all.push_back({"by_label.LABEL", "", "samples, coverage and width_p50 of one label", cover_by_label});
    return all;
  }();
  return keys;
}

// Lists by point, one for each level.
Json widths_json(const BarsShown& shown) {
  Json columns = Json::array();
  for (std::size_t level = 0; level < bar_levels.size(); ++level) {
    Json& column = columns.emplace_back(shown.bars || !shown.points ? Json::array() : Json());
    if (shown.bars && shown.points)
      for (const BarWidths& bar : shown.bars->at) column.push_back(number(bar[level]));
  }
  return columns;
}

}  // namespace

const JsonKeys<BarsShown>& bar_keys() {
  using S = BarsShown;
  static const JsonKeys<S> keys{
      {"bar90,bar95,bar99", "N", "lists: half-width of each point's error bar; null: not known", widths_json},
      json_object<S>("error_bar", error_bar_keys(), "", &S::bars)};
  return keys;
}

std::string expectation_in_words(const AutoModel& chosen, const SharedError& shared, const Told& told) {
  if (!std::isfinite(chosen.p95))
    return "too few states to choose a model by leaving some out: the default is used, its error is unknown";
  std::string text = fmt::format(
      "expected error p50 {:.3g}{}, p95 {:.3g}{}: of {} with known {}, left out in "
      "{} {}",
      chosen.p50, told.unit, chosen.p95, told.unit, counted(chosen.positions, "comparison"), told.things,
      counted(chosen.groups, "group"),
      chosen.alike ? "as far from the rest as the points are from the states"
                   : "that lie nearer to the rest than the points to the states");
  if (chosen.field && chosen.field->law.noise > 0.1 * chosen.p50)
    text += fmt::format("; measuring noise of {:.2g}{} in one component is part of it",
                        chosen.field->law.noise, told.unit);
  if (chosen.across)
    text +=
        "; at points across the states, whose direction they do not know, it is the stiffness along the "
        "states "
        "times the distance";
  if (shared.rounding > 0)
    text += fmt::format("; {:.3g}{} of it because {} are rounded to steps of {:.3g}{}", shared.rounding,
                        told.unit, told.things, shared.step, told.unit);
  if (shared.courses > 0)
    text += fmt::format(
        "; {:.3g}{} of it because {} at one position differ alike along the states, as in loading and "
        "unloading: their mean is taken",
        shared.courses, told.unit, told.things);
  if (chosen.beyond > 0)
    text += fmt::format("; {} farther from them than any left out: more is to be expected there",
                        counted(chosen.beyond, "point lies", "points lie"));
  return text;
}

std::string bars_in_words(const EvaluatedBars& bars, bool asked_for, const Told& told) {
  const BarCover all = bars.measured->cover();
  if (all.samples == 0) return "error bars: unknown, too few states to leave some out";
  std::string text = fmt::format(
      "error bars of 90/95/99 %: {} of {} {} lie inside", shares(all), all.samples,
      bars.measured->checked() ? std::string("check solves")
                               : fmt::format("comparisons with known {}, left out in groups,", told.things));
  if (std::isfinite(all.width_p50))
    text += fmt::format("; median half-width of 95 % {:.3g}{}", all.width_p50, told.unit);
  std::vector<double> asked;
  if (asked_for)
    for (const auto& bar : bars.at)
      if (std::isfinite(bar[1])) asked.push_back(bar[1]);
  if (!asked.empty()) {
    const std::string points = counted(asked.size(), "point");
    text += fmt::format("; at {} asked for {:.3g}{}", points, median(std::move(asked)), told.unit);
  }
  for (const Label label : all_labels)
    if (const BarCover own = bars.measured->cover(label); own.samples >= few && own.samples < all.samples)
      text += fmt::format("; {} {} of {}", name(label), shares(own), own.samples);
  if (bars.outside > 0) {
    const BarCover out = bars.measured->cover_outside();
    text +=
        fmt::format("; {} outside the states, with the bars of {} left out",
                    counted(bars.outside, "point lies", "points lie"), counted(out.samples, "outermost one"));
    if (std::isfinite(out.inside[0])) text += fmt::format(": {} inside", shares(out));
  }
  if (all.samples < 99) text += "; too few for a bar of 99 %";
  if (too_few_inside(all)) text += "; fewer than they should, so the bars are too narrow";
  if (bars.beyond > 0)
    text += fmt::format(
        "; {} farther from the states, or farther outside them, than any left out: bars "
        "there are an "
        "extrapolation or missing",
        counted(bars.beyond, "point lies", "points lie"));
  return text;
}

DeclaredTable left_out_output() {
  return {"NAME_left_out.vtu",
          "What classify --bars writes beside -o NAME.vtu: forces left out.",
          {{"error", "N", "", "distance of the known force from the one that the other states give"},
           {"bar90,bar95,bar99", "N", "", "half-widths of the error bars there, without its own group"},
           {"force", "N", "", "magnitude of the known force"},
           {"away", "m", "", "distance to the nearest state that was not left out"}}};
}

void write_left_out_vtu(const std::filesystem::path& file, const OfflineBars& bars) {
  const std::span<const BarSample> samples = bars.samples();
  VtuWriter out(file, VtuData::text);
  const auto array = [&](const std::string& name, auto&& value) {
    out.array<double>(name, samples.size(), 1, [&](std::size_t i, int) {
      const double one = value(samples[i]);
      return std::isfinite(one) ? one : unknown;
    });
  };
  out.begin(samples.size(), samples.size());
  out.section("PointData");
  array("error", [](const BarSample& s) { return s.error; });
  for (std::size_t level = 0; level < bar_levels.size(); ++level)
    array(fmt::format("bar{}", level_names[level]), [level](const BarSample& s) { return s.bar[level]; });
  array("force", [](const BarSample& s) { return s.force; });
  array("away", [](const BarSample& s) { return s.seen.away; });
  std::vector<Vec3> at;
  for (const BarSample& s : samples) at.push_back(s.at);
  out.points(at);
  out.vertices(at.size());
  out.finish();
}

std::string advice_in_words(const SpacingAdvice& advice, const Tolerance& tolerance) {
  if (std::isnan(advice.spacing))
    return fmt::format(
        "no spacing suggested: at none would 95 % of at least 20 forces left out be safe and within {}",
        in_words(tolerance));
  std::string text = fmt::format(
      "suggested: --spacing {:.2g}: {:.0f} % of {} safe at it lie within {}", advice.spacing,
      100.0 * static_cast<double>(advice.within) / static_cast<double>(advice.safe),
      counted(advice.safe, "force left out that is", "forces left out that are"), in_words(tolerance));
  if (advice.wider > 0)
    text += fmt::format(", but {:.0f} % of the next {}, up to 1.5 times as wide",
                        100.0 * static_cast<double>(advice.wider_within) / static_cast<double>(advice.wider),
                        advice.wider);
  if (advice.all) text += "; these states show no wider one";
  return text;
}

const JsonKeys<SpacingAdvice>& advice_keys() {
  using A = SpacingAdvice;
  static const JsonKeys<A> keys{
      {"spacing", "m",
       "largest spacing at which 95 % of the forces left out that are safe lie within the tolerance; null: "
       "none",
       &A::spacing},
      {"safe,within", "1", "number of forces left out that are safe at it, and of these within the tolerance",
       [](const A& a) {
         return Json{a.safe, a.within};
       }},
      {"wider,wider_within", "1",
       "the same for forces that are safe only at a larger spacing, up to 1.5 times",
       [](const A& a) {
         return Json{a.wider, a.wider_within};
       }},
      {"all", "", "true: all forces left out are safe at it; a larger one may also hold", &A::all}};
  return keys;
}

}  // namespace forefeel
