#include "apps/study/study_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/console/provenance.hpp"
#include "apps/picture/page.hpp"
#include "apps/picture/plot.hpp"
#include "apps/study/study_figures.hpp"
#include "apps/study/study_table.hpp"
#include "geometry/common/counted.hpp"

namespace forefeel {
namespace {

// Text: how intervals of shares are computed. Those of differences need no transformation.
constexpr const char* share_intervals =
    "Student intervals of shares are computed on the logit scale, logit m ± t s / (√G m (1 − m)) over G "
    "traces, and transformed back, so that they stay within 0 and 100 % (logit interval: Brown, Cai, "
    "DasGupta, Statistical Science 16, 2001; with the variance between traces as in svyciprop, method "
    "xlogit, Lumley, Complex Surveys, 2010). If every trace has 100 %, the interval has no width. Intervals "
    "of differences are plain Student intervals.";

// ---- numbers

std::string shown(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g}", value) : "–";
}

std::string shown(const StudyMetric& metric, const ConfidenceInterval& interval, bool with_mean) {
  std::string text = with_mean ? shown(in_unit(metric, interval.mean)) : "";
  if (!says_something(metric, interval)) return text + (with_mean ? "" : "–");
  return text + fmt::format("{}[{}, {}]", with_mean ? " " : "", shown(in_unit(metric, interval.low)),
                            shown(in_unit(metric, interval.high)));
}

// A difference in the metric's unit, or a factor.
std::string shown_difference(const StudyMetric& metric, const ConfidenceInterval& d, bool with_mean) {
  const auto one = [&](double value) {
    if (!std::isfinite(value)) return std::string("–");
    return metric.ratio ? fmt::format("×{:.3g}", std::exp(value))
                        : fmt::format("{:+.3g}", metric.scale * value);
  };
  std::string text = with_mean ? one(d.mean) : "";
  if (!std::isfinite(d.low) || !(d.high > d.low)) return text + (with_mean ? "" : "–");
  return text + fmt::format("{}[{}, {}]", with_mean ? " " : "", one(d.low), one(d.high));
}

std::string verdict(const StudyMetric& metric, const Comparison& c, int sign) {
  if (c.won == 0 && c.lost == 0) return "tie: equal in all";
  if (sign == 0) return "not significant";
  return (sign > 0) == metric.larger_is_better ? "better" : "worse";
}

std::string cell(const std::string& text) {
  return "<td class=\"n\">" + text + "</td>";
}
std::string row(const std::string& name, const std::string& cells) {
  return "<tr><td>" + html_escaped(name) + "</td>" + cells + "</tr>\n";
}
std::string head(std::initializer_list<std::string> titles) {
  std::string html = "<table><tr>";
  for (const std::string& title : titles) html += "<th>" + html_escaped(title) + "</th>";
  return html + "</tr>\n";
}

// ---- pictures

std::string picture(const std::optional<Figure>& figure) {
  if (!figure) return "";
  const auto svg = draw_svg(figure->name, figure->width, figure->height, figure->script);
  if (!svg) return "<p class=\"note\">A picture is missing: gnuplot was not found or failed.</p>\n";
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n", *svg, html_escaped(figure->caption));
}

// ---- sections

struct StudyResults {
  const Study& study;
  const std::vector<StudyCellResult>& cells;
};

// The verdict in words and what to do next, before any figure.
std::string verdict_section(const StudyResults& results) {
  const auto verdict = study_verdict(results.study, results.cells);
  if (!verdict) return "";
  const std::vector<std::string> advice = study_advice(results.study, results.cells);
  const bool shown = verdict->find("the difference is significant") != std::string::npos;
  std::string html = fmt::format("<div class=\"verdict {}\"><p><b>{}</b></p>\n", shown ? "good" : "warn",
                                 html_escaped(*verdict));
  if (!advice.empty()) {
    html += "<ul>\n";
    for (const std::string& line : advice) html += "<li>" + html_escaped(line) + "</li>\n";
    html += "</ul>\n";
  }
  return html + "</div>\n";
}

// Values printed beside a ranking: means over the cells of one value, in the unit of the title.
struct Beside {
  const char *key, *title;
  double scale;
};
constexpr Beside beside[] = {{"error.first_visit.p95", "error p95 [%]", 100},
                             {"error.first_visit.p95_N", "error p95 [mN]", 1e3},
                             {"safety.clamped_share", "clamped [%]", 100},
                             {"energy.generated_J", "energy given back [mJ]", 1e3}};

double mean_at(const StudyResults& results, std::size_t axis, std::size_t level, const std::string& key) {
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < results.cells.size(); ++i) {
    const double value = results.cells[i].number(key);
    if (results.study.choice(results.study.combination_of(i))[axis] != level || !std::isfinite(value))
      continue;
    sum += value;
    ++n;
  }
  return n > 0 ? sum / static_cast<double>(n) : std::nan("");
}

// Values that are not significantly different from the first share its place: "1=". Bounds have none.
std::string place_of(const StudyAxis& axis, const std::vector<Ranked>& ranked, std::size_t i) {
  if (standing_of(axis, ranked[i].level) != Standing::contender) return "";
  const bool any_tie = std::ranges::any_of(ranked.begin() + 1, ranked.end(), [&](const Ranked& row) {
    return row.tied && standing_of(axis, row.level) == Standing::contender;
  });
  if (i == 0 || ranked[i].tied) return any_tie ? "1=" : "1";
  return std::to_string(i + 1);
}

bool few_motions(const AxisRanking& entry) {
  return entry.ranking.ranked.front().value.groups < fewest_motions;
}

std::string ranking_table(const StudyResults& results, const AxisRanking& entry) {
  const StudyAxis& axis = results.study.axes[entry.axis];
  const std::vector<Ranked>& ranked = entry.ranking.ranked;
  const StudyMetric& metric = entry.metric;
  std::string html = "<div class=\"scroll\"><table class=\"ranking\"><tr>";
  for (const std::string& title : {std::string(), axis.column, std::string("mean [bootstrap]"),
                                   std::string("[Student]"), std::string("against the first [bootstrap]"),
                                   std::string("[Student]"), std::string("p, Holm"), std::string()})
    html += (title == axis.column ? "<th class=\"name\">" : "<th>") + html_escaped(title) + "</th>";
  for (const Beside& column : beside) html += "<th>" + html_escaped(column.title) + "</th>";
  html += "</tr>\n";
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    const Ranked& r = ranked[i];
    const bool first = i == 0;
    html += "<tr><td class=\"n\">" + place_of(axis, ranked, i) + "</td><td class=\"name\">" +
            html_escaped(name_of(axis, r.level)) + "</td>" + cell(shown(metric, r.value.bootstrap, true)) +
            cell(shown(metric, r.value.student, false)) +
            cell(first ? "" : shown_difference(metric, r.to_best.bootstrap, true)) +
            cell(first ? "" : shown_difference(metric, r.to_best.student, false)) +
            cell(std::isfinite(r.holm) ? fmt::format("{:.2g}", r.holm) : "") +
            cell(first                                           ? ""
                 : standing_of(axis, r.level) == Standing::bound ? "reached by no real policy"
                 : r.holm > significant
                     ? "not significant"
                     : verdict(metric, r.to_best, r.to_best.verdict()) +
                           (standing_of(axis, r.level) == Standing::placebo ? " (placebo)" : ""));
    for (const Beside& column : beside)
      html += cell(shown(column.scale * mean_at(results, entry.axis, r.level, column.key)));
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

// "Floor (random): 61 …; ceiling (clairvoyant): 93 …", and what a study of this spread can show.
std::string floor_and_ceiling(const StudyAxis& axis, const AxisRanking& entry) {
  std::string text;
  for (const auto& [standing, title] : {std::pair{Standing::placebo, "Floor"}, {Standing::bound, "Ceiling"}})
    for (const Ranked& r : entry.ranking.ranked)
      if (standing_of(axis, r.level) == standing)
        text += fmt::format("{} ({}): {:.3g}. ", title, axis.values[r.level].text,
                            in_unit(entry.metric, r.value.student.mean));
  if (entry.metric.share && entry.ranking.ranked.size() > 1)
    if (const auto needed = motions_needed(entry.ranking.ranked[1].to_best, 0.02))
      text += fmt::format("A difference of 2 points between the first two needs {} (power 80 %).",
                          counted(*needed, "motion"));
  return text.empty() ? "" : "<p>" + html_escaped(text) + "</p>\n";
}

std::string ranking_section(const StudyResults& results, const AxisRanking& entry, const Palette& palette) {
  const StudyAxis& axis = results.study.axes[entry.axis];
  std::string html = fmt::format(
      "<h2>Ranking of {}: {} ({})</h2>\n", html_escaped(axis.column), html_escaped(entry.metric.title),
      counted(entry.ranking.blocks, "pair of motion and seed", "pairs of motion and seed"));
  if (entry.ranking.ranked.empty())
    return html + "<p class=\"note\">No motion and seed has a result for every value.</p>\n";
  html += picture(ranking_figure(results.study, entry, palette)) + ranking_table(results, entry) +
          floor_and_ceiling(axis, entry) + picture(ranks_figure(results.study, entry, palette));
  if (few_motions(entry))
    html += fmt::format("<p class=\"note\">{} too few to compare: no interval is given.</p>\n",
                        counted(entry.ranking.ranked.front().value.groups, "motion is", "motions are"));
  if (std::ranges::find(axis.values, std::string("clairvoyant"), &StudyValue::text) != axis.values.end())
    html +=
        "<p class=\"muted\">clairvoyant knows the motion and the costs. It simulates the session under every "
        "policy except the placebos, with the motion known and unknown, and runs the best at first visits. "
        "None of these policies therefore has a regret below zero there. Better orders of solves may exist, "
        "so the true regrets are at least those shown.</p>\n";
  return html +
         fmt::format(
             "<p class=\"muted\">\"1=\": not significantly different from the first. Against the first: the "
             "row minus the first. A difference counts where both intervals exclude zero and p, "
             "adjusted by Holm over the values that compete, is at most 0.05: Student's is wide "
             "with few motions, the bootstrap's too narrow below about five. Error, clamping and energy are "
             "means over all cells.{}</p>\n",
             entry.ranking.dropped > 0
                 ? fmt::format(" {} a value and left out.",
                               counted(entry.ranking.dropped, "pair of motion and seed lacks",
                                       "pairs of motion and seed lack"))
                 : "");
}

std::size_t pairs_of(const Contrast& contrast) {
  return contrast.comparison.pairs;
}

std::string contrast_section(const Study& study, const std::vector<Contrast>& compared) {
  if (compared.empty()) return "";
  const StudyMetric metric = compared.front().metric;
  const StudyAxis& axis = study.axes.front();
  std::string html = fmt::format("<h2>{}: {} (up to {})</h2>\n",
                                 axis.column == "step" ? "What each step is worth" : "Pairwise comparisons",
                                 html_escaped(metric.title),
                                 counted(std::ranges::max(compared, {}, pairs_of).comparison.pairs, "pair"));
  html += fmt::format(
      "<p class=\"muted\">{}; paired by motion and seed. \"Not significant\": at least one 95 % "
      "interval contains zero difference, or p, adjusted by Holm over the rows of one place, exceeds "
      "0.05.</p>\n",
      html_escaped(metric.title));
  html += "<div class=\"scroll\">" + head({axis.column, "against", "where", "difference [bootstrap]",
                                           "[Student]", "won / lost / pairs", "traces", "p, Holm", ""});
  for (const Contrast& c : compared) {
    const std::string where = c.slice ? study.axes[c.slice->axis].column + " = " +
                                            study.axes[c.slice->axis].values[c.slice->value].text
                                      : "everywhere";
    html += row(
        axis.values[c.a].text,
        "<td>" + html_escaped(axis.values[c.b].text) + "</td><td>" + html_escaped(where) + "</td>" +
            cell(shown_difference(metric, c.comparison.bootstrap, true)) +
            cell(shown_difference(metric, c.comparison.student, false)) +
            cell(metric.larger_is_better
                     ? fmt::format("{} / {} / {}", c.comparison.won, c.comparison.lost, c.comparison.pairs)
                     : fmt::format("{} / {} / {}", c.comparison.lost, c.comparison.won, c.comparison.pairs)) +
            cell(std::to_string(c.comparison.groups)) +
            cell(std::isfinite(c.holm) ? fmt::format("{:.2g}", c.holm) : "") +
            cell(verdict(metric, c.comparison, c.verdict())));
  }
  return html + "</table></div>\n";
}

std::string metrics_section(const StudyResults& results) {
  if (results.study.axes.empty()) return "";
  const StudyAxis& axis = results.study.axes.front();
  std::string html = fmt::format(
      "<h2>Every measure by {} ({})</h2>\n<div class=\"scroll\"><table><tr><th>mean over all "
      "cells</th>",
      html_escaped(axis.column), counted(results.cells.size(), "cell"));
  const std::vector<std::size_t> order = ranked_levels(results.study, results.cells, 0);
  for (const std::size_t level : order) html += "<th>" + html_escaped(name_of(axis, level)) + "</th>";
  html += "</tr>\n";
  for (const StudyMetric& metric : study_metrics(results.study)) {
    std::string line;
    bool any = false;
    for (const std::size_t level : order) {
      const double mean = metric.scale * mean_at(results, 0, level, metric.key);
      any = any || std::isfinite(mean);
      line += cell(shown(mean));
    }
    if (any) html += row(metric.title, line);
  }
  return html + "</table></div>\n";
}

std::string devices_section(const std::vector<StudyDevice>& devices) {
  std::string html = "<h2>Devices</h2>\n<div class=\"scroll\"><table><tr>";
  for (const std::string& title : device_titles()) html += "<th>" + html_escaped(title) + "</th>";
  html += "</tr>\n";
  for (const StudyDevice& device : devices) {
    const std::vector<std::string> texts = device_row(device);
    std::string line;
    for (std::size_t i = 1; i < texts.size(); ++i) line += cell(html_escaped(texts[i]));
    html += row(texts.front(), line);
  }
  return html +
         "</table></div>\n<p class=\"muted\">Means over the cells of each device. Clamped and slewed: frames "
         "at "
         "the force "
         "and the slew limit. Outside: time outside the box of states. Saturation: time that the workers "
         "solve. A session ends with its motion.</p>\n";
}

std::string plan_section(const PlannedStudy& planned) {
  std::string html = "<h2>What varies</h2>\n" + head({"key", "values"});
  for (const StudyAxis& axis : planned.plan.study.axes) {
    std::string values;
    for (const StudyValue& value : axis.values)
      values += (values.empty() ? "" : ", ") + html_escaped(value.text);
    html += row(axis.column, "<td>" + values + "</td>");
  }
  std::string seeds;
  for (const std::uint64_t seed : planned.file.seeds)
    seeds += (seeds.empty() ? "" : ", ") + std::to_string(seed);
  html += row("seed", "<td>" + seeds + "</td>") + "</table>\n";
  return html + "<details><summary>The study</summary><pre>" + html_escaped(planned.file.text) +
         "</pre></details>\n";
}

std::string provenance_section(const PlannedStudy& planned) {
  const auto document = provenance(planned.scenes.front().source.hash);
  std::string html = "<h2>Provenance</h2>\n<table class=\"wide\">\n";
  for (const char* key : {"version", "commit", "machine"})
    html += row(key, cell(html_escaped(document[key].get<std::string>())));
  return html + "</table>\n";
}

}  // namespace

std::vector<std::string> sustained_notes(const Study& study, const std::vector<StudyCellResult>& cells) {
  if (!study.sustained) return {};
  const auto failed =
      std::ranges::count_if(cells, [](const StudyCellResult& c) { return c.number("sustained.speed") == 0; });
  std::vector<std::string> notes{
      "All measures except the sustained speed are those of each session at its own sustained speed."};
  if (failed > 0)
    notes.push_back(fmt::format(
        "In {} of {} not even the lowest speed tried, {:.3g} mm/s, is sustained. cells.csv gives 0 for "
        "them. Here they count as that speed, which favours them: factors against them are lower bounds.",
        failed, counted(cells.size(), "cell"), 1e3 * study.sustained->low));
  return notes;
}

std::string study_page(const PlannedStudy& planned, const StudyResult& result,
                       const std::vector<AxisRanking>& ranked, const std::vector<Contrast>& compared,
                       const std::vector<std::string>& first, const Palette& palette) {
  const Study& study = planned.plan.study;
  const StudyResults results{study, result.cells};
  const std::vector<StudyDevice> devices = study_devices(planned.plan, result.cells);
  std::string html = fmt::format(
      "<h1>{}</h1>\n<p class=\"sub\">{} under the virtual clock: {}, {}; scene "
      "{}. "
      "One row each in cells.csv.</p>\n",
      html_escaped(planned.file.file.stem().string()), counted(planned.plan.cells.size(), "session"),
      counted(study.combinations(), "combination"), counted(study.seeds.size(), "seed"),
      html_escaped(planned.file.scene.filename().string()));
  html += verdict_section(results);
  std::vector<std::string> notes = first;
  std::ranges::copy(attention(devices), std::back_inserter(notes));
  std::ranges::copy(planned.warnings, std::back_inserter(notes));
  std::ranges::copy(sustained_notes(study, result.cells), std::back_inserter(notes));
  std::ranges::copy(notes_of(result.cells), std::back_inserter(notes));
  if (!notes.empty()) {
    html += "<ul class=\"note\">\n";
    for (const std::string& warning : notes) html += "<li>" + html_escaped(warning) + "</li>\n";
    html += "</ul>\n";
  }
  html += devices_section(devices);
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    html += ranking_section(results, ranked[i], palette);
    if (ranked[i].axis == 0) {
      for (const StudyMetric& metric : compared_metrics(study)) {
        std::vector<Contrast> some;
        std::ranges::copy_if(compared, std::back_inserter(some),
                             [&](const Contrast& c) { return c.metric.key == metric.key; });
        html += contrast_section(study, some);
      }
      for (std::size_t axis = 1; axis < study.axes.size(); ++axis)
        html += picture(curves_figure(study, result.cells, axis, palette));
      html += metrics_section(results);
    }
  }
  if (primary_metric(study).share)
    html += fmt::format("<p class=\"muted\">{}</p>\n", html_escaped(share_intervals));
  html +=
      "<p class=\"muted\">An observation is one trace with one seed; all other keys are averaged within it. "
      "Intervals are not corrected for their number: one in twenty may exclude zero by chance. The p values "
      "are.</p>\n";
  return html_page("Forefeel study: " + planned.file.file.stem().string(),
                   html + plan_section(planned) + provenance_section(planned));
}

}  // namespace forefeel
