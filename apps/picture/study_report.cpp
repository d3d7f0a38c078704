#include "apps/picture/study_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "apps/console/provenance.hpp"
#include "apps/picture/page.hpp"
#include "apps/picture/plot.hpp"
#include "apps/study/study_table.hpp"

namespace forefeel {
namespace {

// Colours that can be told apart with every kind of colour vision (Okabe, Ito 2008, without yellow).
constexpr const char* line_colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                        "#e69f00", "#56b4e9", "#1b1b1b", "#8a8a8a"};

// Text: how intervals of shares are computed. Those of differences need no transformation.
constexpr const char* share_intervals =
    "Student intervals of shares are computed on the logit scale, logit m ± t s / (√G m (1 − m)) over G "
    "traces, and transformed back, so that they stay within 0 and 100 % (logit interval: Brown, Cai, "
    "DasGupta, Statistical Science 16, 2001; with the variance between traces as in svyciprop, method "
    "xlogit, Lumley, Complex Surveys, 2010). If every trace has 100 %, the interval has no width. Intervals "
    "of differences are plain Student intervals.";

// ---- numbers

double back(const StudyMetric& metric, double value) {
  return metric.scale * (metric.ratio ? std::exp(value) : value);
}

std::string shown(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g}", value) : "–";
}

std::string shown(const StudyMetric& metric, const ConfidenceInterval& interval, bool with_mean) {
  std::string text = with_mean ? shown(back(metric, interval.mean)) : "";
  if (!std::isfinite(interval.low)) return text + (with_mean ? "" : "–");
  return text + fmt::format("{}[{}, {}]", with_mean ? " " : "", shown(back(metric, interval.low)),
                            shown(back(metric, interval.high)));
}

// A difference in the metric's unit, or a factor.
std::string shown_difference(const StudyMetric& metric, const ConfidenceInterval& d, bool with_mean) {
  const auto one = [&](double value) {
    if (!std::isfinite(value)) return std::string("–");
    return metric.ratio ? fmt::format("×{:.3g}", std::exp(value))
                        : fmt::format("{:+.3g}", metric.scale * value);
  };
  std::string text = with_mean ? one(d.mean) : "";
  if (!std::isfinite(d.low)) return text + (with_mean ? "" : "–");
  return text + fmt::format("{}[{}, {}]", with_mean ? " " : "", one(d.low), one(d.high));
}

std::string verdict(const StudyMetric& metric, const Comparison& c) {
  if (c.verdict() == 0) return "not shown";
  return (c.verdict() > 0) == metric.larger_is_better ? "better" : "worse";
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

// Text as a gnuplot string in single quotes, where '_' and the like are not markup.
std::string label_text(const std::string& text) {
  std::string safe;
  for (const char c : text)
    safe += c == '\'' ? std::string("''") : c == '\n' ? std::string(" ") : std::string(1, c);
  return safe;
}

std::string picture(const std::string& name, int width, int height, const std::string& script,
                    const std::string& caption) {
  const auto svg = draw_svg(name, width, height, script);
  if (!svg) return "<p class=\"note\">A picture is missing: gnuplot was not found or failed.</p>\n";
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n", *svg, html_escaped(caption));
}

std::string ranking_picture(const Study& study, const AxisRanking& entry, std::size_t id) {
  const auto& ranked = entry.ranking.ranked;
  std::string lines, tics;
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    const Comparison& c = ranked[i].value;
    const double mean = back(entry.metric, c.student.mean);
    const auto at = [&](double v) { return std::isfinite(v) ? back(entry.metric, v) : mean; };
    const double y = static_cast<double>(ranked.size() - i);
    lines += fmt::format("{} {} {} {} {} {}\n", mean, y, at(c.bootstrap.low), at(c.bootstrap.high),
                         at(c.student.low), at(c.student.high));
    tics += fmt::format("{}'{}' {}", i > 0 ? ", " : "",
                        label_text(study.axes[entry.axis].values[ranked[i].level].text), y);
  }
  std::string script = data_block("means", lines);
  script += fmt::format(
      "set yrange [0.4:{}]\nset ytics ({}) noenhanced nomirror\nset xtics nomirror out\nset border 3 lc rgb "
      "'#8a8a8a'\n"
      "set grid x lc rgb '#e4e1da'\nset xlabel '{}' noenhanced\nunset key\n{}",
      ranked.size() + 0.6, tics, label_text(entry.metric.title),
      entry.metric.ratio ? "set logscale x\n" : "");
  script +=
      "plot $means using 1:2:5:6 with xerrorbars pt 0 lw 1.2 lc rgb '#8a8a8a', "
      "$means using 1:2:3:4 with xerrorbars pt 7 ps 0.9 lw 2.5 lc rgb '#0b4f7d'\n";
  return picture(
      fmt::format("rank{}", id), 960, std::clamp(110 + 34 * static_cast<int>(ranked.size()), 170, 900),
      script,
      std::string(
          "Mean over traces and seeds; thick: bootstrap interval, thin: Student interval over traces") +
          (entry.metric.share ? " on the logit scale" : "") + ", both 95 %.");
}

std::optional<std::vector<double>> numeric(const StudyAxis& axis) {
  std::vector<double> numbers;
  for (const StudyValue& value : axis.values) {
    double number = 0;
    const auto [end, error] =
        std::from_chars(value.text.data(), value.text.data() + value.text.size(), number);
    if (error != std::errc{} || end != value.text.data() + value.text.size()) return {};
    numbers.push_back(number);
  }
  return numbers;
}

std::string curves_picture(const Study& study, const std::vector<StudyCellResult>& cells, std::size_t axis) {
  const std::optional<std::vector<double>> x = numeric(study.axes[axis]);
  if (!x || x->size() < 2) return "";
  const StudyMetric metric = primary_metric(study);
  const std::size_t levels = study.axes.front().values.size();
  std::string script, plot;
  for (std::size_t level = 0; level < levels; ++level) {
    std::string lines;
    for (std::size_t v = 0; v < x->size(); ++v) {
      const Ranking ranking = rank(observations(study, cells, 0, metric, {{axis, v}}), levels,
                                   metric.larger_is_better, {.shares = metric.share});
      for (const Ranked& r : ranking.ranked)
        if (r.level == level) {
          const auto at = [&](double value) {
            return back(metric, std::isfinite(value) ? value : r.value.student.mean);
          };
          lines += fmt::format("{} {} {} {}\n", (*x)[v], at(r.value.student.mean), at(r.value.bootstrap.low),
                               at(r.value.bootstrap.high));
        }
    }
    script += data_block(fmt::format("level{}", level), lines);
    plot += fmt::format(
        "{}$level{} using 1:2:3:4 with yerrorbars pt 0 lc rgb '{}' notitle, $level{} using 1:2 with "
        "linespoints pt 7 ps 0.6 lw 2 lc rgb '{}' title '{}' noenhanced",
        level > 0 ? ", " : "plot ", level, line_colours[level % 8], level, line_colours[level % 8],
        label_text(study.axes.front().values[level].text));
  }
  const bool positive = std::ranges::all_of(*x, [](double v) { return v > 0; });
  script += fmt::format(
      "set key outside right top\nset border 3 lc rgb '#8a8a8a'\nset tics nomirror out\nset grid lc rgb "
      "'#e4e1da'\n"
      "set xlabel '{}' noenhanced\nset ylabel '{}' noenhanced\n{}{}{}\n",
      label_text(study.axes[axis].column), label_text(metric.title), positive ? "set logscale x\n" : "",
      metric.ratio ? "set logscale y\n" : "", plot);
  return picture(fmt::format("curves{}", axis), 960, 420, script,
                 "Mean over traces and seeds with bootstrap intervals.");
}

// ---- sections

std::string ranking_section(const Study& study, const AxisRanking& entry, std::size_t id) {
  const StudyAxis& axis = study.axes[entry.axis];
  std::string html = fmt::format("<h2>Ranking of {}: {}</h2>\n", html_escaped(axis.column),
                                 html_escaped(entry.metric.title));
  if (entry.ranking.ranked.empty())
    return html + "<p class=\"note\">No trace and seed has a result for every value.</p>\n";
  html += ranking_picture(study, entry, id);
  html += head(
      {"", axis.column, "mean [bootstrap]", "[Student]", "against the first [bootstrap]", "[Student]", ""});
  std::size_t place = 0;
  for (const Ranked& r : entry.ranking.ranked) {
    const bool first = place == 0;
    html += fmt::format("<tr><td>{}</td>", ++place) + "<td>" + html_escaped(axis.values[r.level].text) +
            "</td>" + cell(shown(entry.metric, r.value.bootstrap, true)) +
            cell(shown(entry.metric, r.value.student, false)) +
            cell(first ? "" : shown_difference(entry.metric, r.to_best.bootstrap, true)) +
            cell(first ? "" : shown_difference(entry.metric, r.to_best.student, false)) +
            cell(first ? "" : verdict(entry.metric, r.to_best)) + "</tr>\n";
  }
  html += "</table>\n";
  if (std::ranges::find(axis.values, std::string("clairvoyant"), &StudyValue::text) != axis.values.end())
    html +=
        "<p class=\"muted\">clairvoyant knows the motion and the costs. It simulates the session under every "
        "policy except the placebos, with the motion known and unknown, and runs the best at first visits. "
        "None of these policies therefore has a regret below zero there. Better orders of solves may exist, "
        "so the true regrets are at least those shown.</p>\n";
  return html + fmt::format("<p class=\"muted\">{} traces and seeds{}.</p>\n", entry.ranking.blocks,
                            entry.ranking.dropped > 0 ? fmt::format("; {} more lack a value and are left out",
                                                                    entry.ranking.dropped)
                                                      : "");
}

std::string contrast_section(const Study& study, const std::vector<Contrast>& compared) {
  if (compared.empty()) return "";
  const StudyMetric metric = compared.front().metric;
  const StudyAxis& axis = study.axes.front();
  std::string html =
      axis.column == "step" ? "<h2>What each step is worth</h2>\n" : "<h2>Pairwise comparisons</h2>\n";
  html += fmt::format(
      "<p class=\"muted\">{}; paired by trace and seed. \"Not shown\": at least one 95 % interval "
      "contains zero difference.</p>\n",
      html_escaped(metric.title));
  html += head({axis.column, "against", "where", "difference [bootstrap]", "[Student]", "won / lost / pairs",
                "traces", ""});
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
            cell(std::to_string(c.comparison.groups)) + cell(verdict(metric, c.comparison)));
  }
  return html + "</table>\n";
}

std::string metrics_section(const Study& study, const std::vector<StudyCellResult>& cells) {
  if (study.axes.empty()) return "";
  const StudyAxis& axis = study.axes.front();
  std::string html = fmt::format("<h2>Every measure by {}</h2>\n<table><tr><th>mean over all cells</th>",
                                 html_escaped(axis.column));
  for (const StudyValue& value : axis.values) html += "<th>" + html_escaped(value.text) + "</th>";
  html += "</tr>\n";
  for (const StudyMetric& metric : study_metrics(study)) {
    std::string line;
    bool any = false;
    for (std::size_t level = 0; level < axis.values.size(); ++level) {
      double sum = 0;
      std::size_t n = 0;
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const double value = cells[i].number(metric.key);
        if (study.choice(study.combination_of(i)).front() != level || !std::isfinite(value)) continue;
        sum += metric.scale * value;
        ++n;
      }
      any = any || n > 0;
      line += cell(shown(n > 0 ? sum / static_cast<double>(n) : std::nan("")));
    }
    if (any) html += row(metric.title, line);
  }
  return html + "</table>\n";
}

std::string devices_section(const std::vector<StudyDevice>& devices) {
  std::string html = "<h2>Devices</h2>\n<table><tr>";
  for (const std::string& title : device_titles()) html += "<th>" + html_escaped(title) + "</th>";
  html += "</tr>\n";
  for (const StudyDevice& device : devices) {
    const std::vector<std::string> texts = device_row(device);
    std::string line;
    for (std::size_t i = 1; i < texts.size(); ++i) line += cell(html_escaped(texts[i]));
    html += row(texts.front(), line);
  }
  return html +
         "</table>\n<p class=\"muted\">Means over the cells of each device. Clamped and slewed: frames at "
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
  const auto document = provenance(planned.scenes.front().hash);
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
        "In {} of {} cells not even the lowest speed tried, {:.3g} mm/s, is sustained. cells.csv gives 0 for "
        "them. Here they count as that speed, which favours them: factors against them are lower bounds.",
        failed, cells.size(), 1e3 * study.sustained->low));
  return notes;
}

std::string study_page(const PlannedStudy& planned, const StudyResult& result,
                       const std::vector<AxisRanking>& ranked, const std::vector<Contrast>& compared) {
  const Study& study = planned.plan.study;
  const std::vector<StudyDevice> devices = study_devices(planned.plan, result.cells);
  std::string html = fmt::format(
      "<h1>{}</h1>\n<p class=\"sub\">{} sessions under the virtual clock: {} combinations, {} seeds; scene "
      "{}. "
      "One row each in cells.csv.</p>\n",
      html_escaped(planned.file.file.stem().string()), planned.plan.cells.size(), study.combinations(),
      study.seeds.size(), html_escaped(planned.file.scene.filename().string()));
  std::vector<std::string> notes = attention(devices);
  std::ranges::copy(planned.warnings, std::back_inserter(notes));
  std::ranges::copy(sustained_notes(study, result.cells), std::back_inserter(notes));
  if (!notes.empty()) {
    html += "<ul class=\"note\">\n";
    for (const std::string& warning : notes) html += "<li>" + html_escaped(warning) + "</li>\n";
    html += "</ul>\n";
  }
  if (const auto verdict = study_verdict(study, result.cells))
    html += "<p><b>" + html_escaped(*verdict) + "</b></p>\n";
  html += devices_section(devices);
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    html += ranking_section(study, ranked[i], i);
    if (ranked[i].axis == 0) {
      for (const StudyMetric& metric : {primary_metric(study), second_metric(study)}) {
        std::vector<Contrast> some;
        std::ranges::copy_if(compared, std::back_inserter(some),
                             [&](const Contrast& c) { return c.metric.key == metric.key; });
        html += contrast_section(study, some);
      }
      for (std::size_t axis = 1; axis < study.axes.size(); ++axis)
        html += curves_picture(study, result.cells, axis);
      html += metrics_section(study, result.cells);
    }
  }
  if (primary_metric(study).share)
    html += fmt::format("<p class=\"muted\">{}</p>\n", html_escaped(share_intervals));
  html +=
      "<p class=\"muted\">An observation is one trace with one seed; all other keys are averaged within it. "
      "Intervals are not corrected for multiple comparisons: one in twenty may exclude zero by chance.</p>\n";
  return html_page("Forefeel study: " + planned.file.file.stem().string(),
                   html + plan_section(planned) + provenance_section(planned));
}

}  // namespace forefeel
