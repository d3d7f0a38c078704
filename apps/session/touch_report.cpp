#include "apps/session/touch_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/picture/figure.hpp"
#include "apps/picture/page.hpp"
#include "apps/picture/plot.hpp"
#include "apps/session/report_figures.hpp"
#include "apps/session/run_charts.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

std::string percent_of(double share) {
  return std::isfinite(share) ? fmt::format("{:.3g} %", 100 * share) : "–";
}

// The run as the charts of a session take it; positions are those of the tip.
SessionResult for_charts(const TouchSessionResult& result) {
  SessionResult session;
  for (const TouchFrameRecord& frame : result.frames) {
    FrameRecord& record = session.frames.emplace_back();
    record.t = frame.t, record.at = frame.tip;
    record.force = frame.force.rendered, record.elastic = frame.force.elastic;
    record.sent = frame.force.sent, record.undamped = frame.force.undamped;
    record.label = frame.label, record.known = frame.source.known;
    record.step = frame.step, record.judged = frame.judged, record.timing = frame.timing;
    if (frame.step.took_model)
      session.switches.push_back({.t = frame.t,
                                  .model = frame.source.model,
                                  .cause = SwitchCause::states,
                                  .label = frame.label,
                                  .n = frame.source.known,
                                  .jump_undamped = frame.step.undamped_jump});
  }
  for (const TouchDispatch& d : result.dispatches) {
    DispatchRecord& record = session.dispatch.emplace_back();
    record.id = d.id, record.at = d.site + d.x, record.status = d.status;
    record.requested = d.requested, record.started = d.started, record.finished = d.finished;
    record.known = d.known, record.worker = d.worker;
  }
  session.counts.start = result.known_at_start, session.counts.failed = result.failed;
  return session;
}

// The body's nodes in grey, the sites in the colour of the error there; seen along two axes.
Figure map_of_sites(const TouchSessionResult& result, const RestSites& rest) {
  std::string nodes, sites;
  for (std::size_t f = 0; f < rest.map().facets().size(); ++f) {
    const auto [a, b, c] = rest.map().corners(static_cast<std::int32_t>(f));
    const Vec3 at = 1e3 * (a + b + c) / 3;
    nodes += fmt::format("{:.4g} {:.4g} {:.4g}\n", at[0], at[1], at[2]);
  }
  for (const TouchFrameRecord& frame : result.frames)
    if (std::isfinite(frame.judged.error))
      sites += fmt::format("{:.4g} {:.4g} {:.4g} {:.4g}\n", 1e3 * frame.site.at[0], 1e3 * frame.site.at[1],
                           1e3 * frame.site.at[2], std::max(1e-3, 100 * frame.judged.error));
  Figure figure;
  figure.name = "sites";
  figure.caption =
      "Where on the body the hand was (facets in grey, seen along y and along z), by the error of the "
      "rendered force there in %.";
  figure.width = 960, figure.height = 440;
  if (sites.empty()) sites = "NaN NaN NaN NaN\n";
  figure.script = std::string(plot_style) + data_block("body", nodes) + data_block("sites", sites) +
                  "set multiplot layout 1,2\nset size ratio -1\nset logscale cb\nset cbrange [0.01:100]\n"
                  "set palette defined (0 '#2166ac', 0.5 '#f7f7f7', 0.62 '#f4a582', 1 '#b2182b')\n"
                  "set xlabel 'x [mm]'\nset ylabel 'z [mm]'\nset key off\n"
                  "plot $body using 1:3 with dots lc rgb '#888888', $sites using 1:3:4 with points pt 7 ps "
                  "0.5 lc palette\n"
                  "set ylabel 'y [mm]'\n"
                  "plot $body using 1:2 with dots lc rgb '#888888', $sites using 1:2:4 with points pt 7 ps "
                  "0.5 lc palette\n"
                  "unset multiplot\n";
  return figure;
}

std::vector<std::string> error_row(const std::string& what, const TouchErrors& errors) {
  return {what,
          std::to_string(errors.samples),
          percent_of(errors.p50),
          percent_of(errors.p95),
          percent_of(errors.max),
          percent_of(errors.within_jnd)};
}

std::string errors_table(const TouchSessionResult& result, const TouchSummary& s) {
  std::vector<std::vector<std::string>> rows{
      {"frames", "compared", "p50", "p95", "largest", "within the JND"},
      error_row("samples", s.samples),
      error_row("first visits", s.first_visit),
      error_row("trusted", s.trusted),
      error_row("not trusted", s.untrusted)};
  for (const Label label : all_labels) {
    std::vector<double> errors;
    for (const TouchFrameRecord& frame : result.frames)
      if (frame.label == label && frame.touch != TouchKind::none && frame.judged.sampled &&
          std::isfinite(frame.judged.error))
        errors.push_back(frame.judged.error);
    if (errors.empty()) continue;
    std::ranges::sort(errors);
    rows.push_back({std::string(name(label)), std::to_string(errors.size()),
                    percent_of(errors[errors.size() / 2]), percent_of(errors[errors.size() * 95 / 100]),
                    percent_of(errors.back()), ""});
  }
  return "<h2>Error of the rendered force</h2>\n" + html_table(rows);
}

std::string touch_words(const TouchSummary& s) {
  std::string words = fmt::format(
      "<p>{} touches in {} of the time; the site slid in {} of it, {:.3g} m in all, and lost {:.3g} J. The "
      "force is "
      "that of a field of {} sites at rest, with {} jets made at the hand's place and {} solved states. "
      "Coverage while "
      "touching: safe {}, sparse {}, gap {}, blank {}; the force is trusted in {}.</p>\n",
      s.touch.count, percent_of(s.touch.time), percent_of(s.touch.slipping), s.touch.slid, s.touch.lost,
      s.field.sites, s.states.jets, s.states.solved, percent_of(s.time_in[Label::safe]),
      percent_of(s.time_in[Label::sparse]), percent_of(s.time_in[Label::gap]),
      percent_of(s.time_in[Label::blank]), percent_of(s.time_trusted));
  if (s.touch.angle.size() == 2)
    words += fmt::format(
        "<p>Angle of the force to the normal: {:.0f} degrees at the median, {:.0f} at p95.{}</p>\n",
        s.touch.angle[0] * 57.29578, s.touch.angle[1] * 57.29578,
        s.settings.friction ? "" : " Without contact.friction a touch sticks to its site.");
  return words;
}

}  // namespace

void write_touch_report(const std::filesystem::path& run, const TouchSessionResult& result,
                        const TouchSessionInput& input, const SessionOptions& options,
                        const TouchSummary& summary, const Json& document, const Scene& scene) {
  const SessionResult session = for_charts(result);
  const RunView view{.box = input.task.tips.box,
                     .spacing = input.task.tips.spacing,
                     .force_limit = options.safety.force_limit,
                     .jnd_share = options.switching.jnd_share,
                     .jnd_floor = options.switching.jnd_floor,
                     .error_floor = options.judging.error_floor};
  const auto drawn = [](const Figure& figure) {
    const auto svg = draw_svg(figure.name, figure.width, figure.height, figure.script);
    return svg ? "<figure>" + *svg + "<figcaption>" + html_escaped(figure.caption) +
                     "</figcaption></figure>\n"
               : "";
  };
  std::string html = fmt::format(
      "<h1>{}: touched anywhere</h1>\n<p class=\"sub\">{}, {:.1f} s, {} clock, policy {}, {} workers; {} "
      "tetrahedra, "
      "{}</p>\n",
      html_escaped(scene.source.file.stem().string()), html_escaped(summary.settings.device),
      summary.settings.seconds, summary.settings.clock, html_escaped(summary.settings.policy),
      summary.settings.workers, input.task.field->rest().body().mesh.tets.size(),
      name(input.task.field->rest().body().material.law));
  if (!summary.notes.empty() || summary.interrupted) {
    html += "<ul class=\"note\">\n";
    if (summary.interrupted) html += "<li>The session or its judging ended early.</li>\n";
    for (const std::string& note : summary.notes) html += "<li>" + html_escaped(note) + "</li>\n";
    html += "</ul>\n";
  }
  html += touch_words(summary) + errors_table(result, summary);
  html += "<h2>Where the hand was</h2>\n" + drawn(map_of_sites(result, input.task.field->rest()));
  html += "<h2>Over time</h2>\n" +
          run_charts(session, view, drawn(time_figure(session.frames, view.force_limit)));
  if (has_deadlines(session.frames)) html += drawn(deadline_figure(session.frames));
  html += "<details><summary>All numbers</summary>\n<pre>" + html_escaped(document.dump(2)) +
          "</pre></details>\n";
  write_whole(run / "report.html", html_page("Forefeel: " + scene.source.file.filename().string(), html));
}

}  // namespace forefeel
