#include "apps/session/report.hpp"
#include "apps/console/json.hpp"
#include "apps/console/summary_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "apps/picture/page.hpp"
#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"
#include "apps/picture/slice_figure.hpp"
#include "apps/session/all_numbers.hpp"
#include "apps/session/bars_card.hpp"
#include "apps/session/report_figures.hpp"
#include "apps/session/run_charts.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/record/notes.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

// ---- numbers for people

std::string shown(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "–";
}
std::string shown(std::size_t value) {
  return std::to_string(value);
}
std::string percent(double share) {
  if (!std::isfinite(share)) return "–";
  return said_percent(share);
}
std::string with_unit(double value, const std::string& unit) {
  return std::isfinite(value) ? shown(value) + " " + unit : "–";
}

std::string tile(const std::string& value, const std::string& what, Judged judged = Judged::plain) {
  const char* const names[] = {"", " good", " warn", " bad"};
  return fmt::format("<div class=\"tile{}\"><b>{}</b><span>{}</span></div>\n",
                     names[static_cast<std::size_t>(judged)], value, what);
}

// Small values are good; a value that is not known is not judged.
Judged small_is_good(double value, double warn, double bad) {
  if (!std::isfinite(value)) return Judged::plain;
  return value > bad ? Judged::bad : value > warn ? Judged::warn : Judged::good;
}

// Shares within the just noticeable difference; with few samples none is good.
Judged within(const SessionSummary::Errors& errors) {
  const Judged judged = small_is_good(1 - errors.within_jnd, 0.05, 0.2);
  return judged == Judged::good && errors.samples < few_samples ? Judged::plain : judged;
}

std::string tiles(const SessionSummary& s) {
  std::string html = "<div class=\"tiles\">\n";
  const SessionSummary::Errors &samples = s.error.samples, &visits = s.error.first_visit;
  const auto frames = static_cast<double>(std::max<std::size_t>(1, s.run.frames));
  html += tile(share_of_samples(samples.within_jnd, samples.samples),
               "sampled frames within the just noticeable difference", within(samples));
  html += tile(share_of_samples(visits.within_jnd, visits.samples),
               "first visits within the just noticeable difference", within(visits));
  html += tile(percent(samples.p95),
               "error of the rendered force, 95th percentile of " + counted(samples.samples, "sample"),
               small_is_good(samples.p95, 0.07, 0.3));
  const Card bars = bars_card(s.error.bars);
  html += tile(bars.value, bars.what, bars.judged);
  if (std::isfinite(s.error.mesh.error))
    html += tile(percent(s.error.mesh.error), "error of the mesh itself, not part of the errors before",
                 s.error.mesh.error > felt_share ? Judged::warn : Judged::good);
  html += tile(shown(s.switching.frames_over_jnd),
               fmt::format("of {} in which a switch exceeded its bound", counted(s.run.frames, "frame")),
               small_is_good(static_cast<double>(s.switching.frames_over_jnd), 0, 0));
  html += tile(with_unit(s.switching.max_jump, "N"),
               fmt::format("largest change by one of {} in one frame; {} undamped",
                           counted(s.switching.count, "switch", "switches"),
                           with_unit(s.switching.max_jump_undamped, "N")));
  html += tile(percent(s.time_in[Label::safe]),
               fmt::format("of {} in safe regions (densely known)", counted(s.run.frames, "frame")),
               s.motion.touch ? Judged::plain : small_is_good(1 - s.time_in[Label::safe], 0.5, 0.9));
  html += s.states.foreign
              ? tile(shown(s.states.start), "known states of another body; none was solved")
              : tile(shown(s.states.solved), "states solved; " + shown(s.states.used) + " used by a model");
  html += tile(shown(s.load),
               "load: states that the motion needs over states that are solved; above 1 workers lag",
               small_is_good(s.load, 1, 3));
  html += tile(percent(s.safety.clamped_share),
               fmt::format("of {} clamped at {}; {} at the slew limit", counted(s.run.frames, "frame"),
                           with_unit(s.safety.force_limit, "N"), percent(s.safety.slewed_share)),
               small_is_good(s.safety.clamped_share, 0, clamped_too_often));
  if (std::isfinite(s.motion.outside))
    html += tile(percent(s.motion.outside),
                 fmt::format("of {} outside the box of states", counted(s.run.frames, "frame")),
                 outside_is_felt(s) ? Judged::bad : Judged::plain);
  if (s.settings.clock == Clock::real)
    html += tile(shown(s.deadline.missed),
                 "deadlines missed of " + counted(s.run.frames, "frame") + "; a frame costs " +
                     with_unit(s.deadline.cost_us.p50, "µs") + " (median; p99 " +
                     with_unit(s.deadline.cost_us.p99, "µs") + ")",
                 small_is_good(static_cast<double>(s.deadline.missed) / frames, 0, 0.01));
  return html + "</div>\n";
}

// ---- sections

std::string touch_words(const SessionSummary& s) {
  if (!s.motion.touch) return "";
  const TouchNumbers& t = *s.motion.touch;
  std::string words = fmt::format(
      "<p>{} in {} of the time; the site slid in {} of the time in touch, {:.3g} m in all, and lost {}. {} "
      "made at the hand's place. Shares of labels and of trust are of the time in touch.",
      counted(t.count, "touch", "touches"), percent(t.time), percent(t.slipping), t.slid, said_joules(t.lost),
      counted(t.jets, "jet at rest was", "jets at rest were"));
  if (std::isfinite(t.angle_p50))
    words += fmt::format(" Angle of the force to the normal: {:.0f} degrees at the median, {:.0f} at p95.",
                         t.angle_p50 * 57.29578, t.angle_p95 * 57.29578);
  if (t.out_of_cone > 0) words += " The " + out_of_cone_in_words(t) + ".";
  return words + "</p>\n";
}

std::string legend(const SessionSummary& summary) {
  std::string html = "<p class=\"legend\">";
  for (const Label label : all_labels)
    html += fmt::format("<span><i style=\"background:{}\"></i>{} {}</span>", colour(label), name(label),
                        percent(summary.time_in[label]));
  return html + "<span class=\"muted\">share of the time</span></p>\n";
}

std::string figure(const Figure& f) {
  const std::optional<std::string> svg = draw_svg(f.name, f.width, f.height, f.script);
  if (!svg)
    return fmt::format("<p class=\"note\">The picture \"{}\" could not be drawn by gnuplot.</p>\n", f.name);
  return fmt::format("<figure style=\"margin-bottom:12px\">{}<figcaption>{}</figcaption></figure>\n", *svg,
                     html_escaped(f.caption));
}

// Each picture is its own gnuplot process; they run in parallel.
template <class Make>
Picture drawn(Make make) {
  return std::async(std::launch::async,
                    [make = std::move(make)] { return have_gnuplot() ? figure(make()) : std::string(); })
      .share();
}

std::string pictures(const SessionSummary& summary, const ReportPictures& drawings) {
  std::string html =
      drawings.moments.get() + drawings.charts.get() + "<h2>What was known where</h2>\n" + legend(summary);
  if (!have_gnuplot())
    return html +
           "<p class=\"note\">Plots need gnuplot, which was not found when this report was written.</p>\n";
  if (drawings.slices.valid()) html += drawings.slices.get();
  if (drawings.sites.valid()) html += "<h2>Where the hand was</h2>\n" + drawings.sites.get();
  if (drawings.deadlines.valid())
    html += fmt::format("<h2>Deadlines ({})</h2>\n", counted(summary.run.frames, "frame")) +
            drawings.deadlines.get();
  return html;
}

std::string error_row(std::string_view name, const SessionSummary::Errors& row) {
  if (row.samples == 0) return {};
  const auto cell = [](const std::string& text) { return "<td class=\"n\">" + text + "</td>"; };
  return fmt::format("<tr><td>{}</td>", name) + cell(shown(row.samples)) + cell(percent(row.p50)) +
         cell(percent(row.p95)) + cell(percent(row.max)) + cell(percent(row.within_jnd)) + "</tr>\n";
}

std::string by_label_table(const SessionSummary& summary) {
  std::string html =
      fmt::format("<h2>Error by label ({})</h2>\n", counted(summary.error.samples.samples, "sample")) +
      "<table><tr><th>label</th><th>samples</th><th>p50</th><th>p95</th>"
      "<th>max</th><th>within the JND</th></tr>\n";
  for (const Label label : all_labels) html += error_row(name(label), summary.error.by_label[label]);
  if (std::isfinite(summary.error.time_trusted)) {
    html += error_row("trusted", summary.error.by_trust[1]);
    html += error_row("not trusted", summary.error.by_trust[0]);
  }
  html += "</table>\n";
  if (std::isfinite(summary.error.time_trusted))
    html += fmt::format(
        "<p class=\"muted\">No force here was solved at its place: each is predicted from energy "
        "jets of solved states. Trusted, for {} of the time: no state has contradicted these jets, and "
        "their own estimate is within the tolerance.</p>\n",
        percent(summary.error.time_trusted));
  return html;
}

// The warnings that come before all figures.
std::string attention_box(const SessionSummary& summary) {
  std::string html;
  for (const std::string& line : attention(summary)) html += "<li>" + html_escaped(line) + "</li>\n";
  return html.empty() ? html : "<ul class=\"note\">\n" + html + "</ul>\n";
}

std::string notes(const SessionSummary& summary, const Scene& scene) {
  std::vector<std::string> lines = scene.source.warnings;
  std::ranges::move(remarks(summary), std::back_inserter(lines));
  std::ranges::move(shortened_notes(summary.run.notes), std::back_inserter(lines));
  if (lines.empty()) return "";
  std::string html = fmt::format("<details><summary>Notes ({})</summary>\n<ul>\n", lines.size());
  for (const std::string& line : lines) html += "<li>" + html_escaped(line) + "</li>\n";
  return html + "</ul></details>\n";
}

SliceInput slices_of(const SessionResult& result) {
  SliceInput slice;
  for (const FrameRecord& f : result.frames) {
    slice.t.push_back(f.t);
    for (unsigned axis = 0; axis < 3; ++axis) slice.path[axis].push_back(f.at[axis]);
  }
  const auto take = [&](double known, const Vec3& at) {
    State state;
    state.at = at;
    slice.states.emplace_back(known, std::move(state));
  };
  for (const DispatchRecord& d : result.dispatch)
    if ((d.status == DispatchStatus::solved || d.status == DispatchStatus::arrived) &&
        std::isfinite(d.finished))
      take(std::isfinite(d.known) ? d.known : d.finished, d.at);
  for (std::size_t i = 0; i < result.counts.start; ++i) take(0.0, result.states[i].tip());
  std::ranges::stable_sort(slice.states, {}, [](const auto& known) { return known.first; });
  return slice;
}

}  // namespace

Picture begin_sites(const SessionResult& result, const RestSites& rest) {
  return drawn([figure = site_figure(result.frames, rest.map())] { return figure; });
}

Picture begin_slices(const SessionResult& result, const StateSpaceOptions& space) {
  return drawn([slice = slices_of(result), space] { return slice_figure(slice, space); });
}

std::vector<Figure> run_figures(const SessionResult& result, const StateSpaceOptions& space,
                                const RunView& view) {
  std::vector<Figure> figures{time_figure(result, view), slice_figure(slices_of(result), space)};
  if (has_deadlines(result.frames)) figures.push_back(deadline_figure(result.frames));
  return figures;
}

RunView view_of(const StateSpaceOptions& space, const SessionOptions& options, double force_limit) {
  return {.box = space.box,
          .spacing = space.spacing,
          .force_limit = force_limit,
          .jnd_share = options.switching.jnd_share,
          .jnd_floor = options.switching.jnd_floor,
          .felt = felt_rule(options.switching, options.safety),
          .error_floor = options.judging.error_floor};
}

ReportPictures begin_pictures(const SessionResult& result, Picture slices, const RunView& view) {
  const std::span<const FrameRecord> frames = result.frames;
  ReportPictures drawings{.slices = std::move(slices),
                          .still = drawn([&result, view] { return time_figure(result, view); }),
                          .deadlines = {},
                          .charts = {},
                          .moments = {}};
  if (has_deadlines(frames)) drawings.deadlines = drawn([frames] { return deadline_figure(frames); });
  drawings.charts = std::async(std::launch::async, [&result, view, still = drawings.still] {
                      return run_charts(result, view, still.get());
                    }).share();
  drawings.moments =
      std::async(std::launch::async, [&result, view] { return worst_moments(result, view); }).share();
  return drawings;
}

void write_report(const std::filesystem::path& run_folder, const SessionSummary& s, const Json& document,
                  const Scene& scene, const ReportPictures& drawings) {
  const std::string of_scene = html_escaped(scene.source.file.stem().string());
  const std::string how =
      s.states.foreign
          ? fmt::format("box and motion of {}", of_scene)
          : fmt::format("policy {}, {}, seed {}; {}, {}", html_escaped(s.settings.policy),
                        counted(static_cast<std::size_t>(s.settings.workers), "worker"), s.settings.seed,
                        counted(scene.body->mesh.tets.size(), "tetrahedron", "tetrahedra"),
                        name(scene.body->material.law));
  std::string html =
      fmt::format("<h1>{}</h1>\n{}<p class=\"sub\">{} s, {} clock, switch {}, neighbours by {}; {}</p>\n",
                  s.states.foreign ? "States of another body" : of_scene, attention_box(s),
                  shown(s.run.seconds), s.settings.clock == Clock::real ? "real" : "virtual",
                  name(s.switching.rule), name(s.settings.select), how);
  html += tiles(s) + touch_words(s) + pictures(s, drawings);
  if (drawings.shape.valid()) html += drawings.shape.get();
  html += by_label_table(s) + notes(s, scene) + all_numbers(document) + provenance_section(document);
  write_whole(run_folder / "report.html",
              html_page(s.states.foreign ? "Forefeel: states of another body"
                                         : "Forefeel: " + scene.source.file.filename().string(),
                        html));
}

}  // namespace forefeel
