#include "apps/session/run_charts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "apps/picture/page.hpp"
#include "apps/picture/page_texts.hpp"
#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"
#include "apps/session/bad_moments.hpp"
#include "apps/session/run_data.hpp"

namespace forefeel {
namespace {

std::string key(std::string_view colour, const char* form, const char* text) {
  return fmt::format("<span><i class=\"{}\" style=\"--ink:{}\"></i>{}</span>", form, colour, text);
}

// "196 samples, 44 more at first visits": frames compared at equal distances along the path, and those compared only
// because they are the first in their cell. The cards and the table by label count the samples alone.
std::string compared_in_words(std::span<const FrameRecord> frames) {
  std::size_t samples = 0, visits = 0;
  for (const FrameRecord& f : frames)
    if (std::isfinite(f.judged.error)) ++(f.judged.sampled ? samples : visits);
  return fmt::format("{} samples{}", samples,
                     visits > 0 ? fmt::format(", {} more at first visits", visits) : "");
}

std::string curves(const std::string& compared, std::size_t ending_frames) {
  std::string html = fmt::format("<h2>Force, label and error over time ({})</h2>\n", compared);
  html += "<p class=\"legend\">" + key(ink("rendered"), "line", "rendered, before the safety rules") +
          key(ink("sent"), "dash", "sent to the device") + key(ink("limit"), "dash", "force limit") +
          key(ink("limit") + "33", "box", "clamped") +
          key(ink("undamped"), "line", "newest model, undamped") +
          key(ink("reference_light"), "dot", "reference") + key(ink("bar") + "2e", "box", "error bar, 95 %") +
          "</p>\n<p class=\"legend\"><span>error:</span>" + key(ink("rendered"), "line", "rendered") +
          key(ink("approximation"), "dot", "approximation") + key(ink("switching"), "dot", "switch") +
          key(ink("staleness"), "dot", "staleness") + key("#6a6a6a", "dash", "just noticeable") + "</p>\n";
  html +=
      "<figure><p class=\"bar\"><button id=\"run-all\">whole run</button><button id=\"run-in\">+</button>"
      "<button id=\"run-out\">−</button><button id=\"run-here\">switch at the pointer</button>"
      "<span class=\"muted\">Wheel: zoom. Drag: move. Pointer: read off. Keys: ← → + − 0.</span></p>\n"
      "<canvas id=\"run-time\" tabindex=\"0\" role=\"img\" aria-label=\"force, label, switches, error and "
      "known "
      "states over time\" style=\"height:560px\"></canvas>\n<p id=\"run-read\" class=\"read\"></p>\n";
  const std::string end = ending_frames > 0
                              ? fmt::format(
                                    "; in the last {} frames it shrinks to zero, as fast as the slew limit "
                                    "allows, because the session ends",
                                    ending_frames)
                              : "";
  return html +
         "<figcaption>|force| of the body on the hand. Rendered: after the switch, before the safety rules; "
         "sent: after them" +
         end +
         ". Reference: tight solves along the path. Error bar: the length of the true force is "
         "inside with 95 %. "
         "Ticks of switches: taller for a larger "
         "difference of "
         "the two models.</figcaption></figure>\n";
}

std::string around_switch(std::size_t switches) {
  return fmt::format(
      "<h2>Around one switch ({} in all)</h2>\n<figure><p class=\"bar\"><button id=\"run-before\">‹</button>"
      "<input id=\"run-which\" type=\"range\" min=\"0\" value=\"0\" aria-label=\"number of the switch\">"
      "<button id=\"run-next\">›</button><button id=\"run-largest\">largest</button></p>\n"
      "<p id=\"run-what\"></p>\n<canvas id=\"run-switch\" role=\"img\" aria-label=\"force around one "
      "switch\" "
      "style=\"height:290px\"></canvas>\n<figcaption>60 ms before to 140 ms after the switch (dotted). The "
      "rendered "
      "force leaves the old model and reaches the newest without a step that a hand "
      "feels.</figcaption></figure>\n",
      switches);
}

std::string maps(const std::string& compared) {
  std::string html = fmt::format("<h2>Where the errors were ({})</h2>\n<p class=\"legend\">", compared);
  html += key(ink("within"), "dot", "within the just noticeable difference (JND)") +
          key(ink("above"), "dot", "1 to 3 JND") + key(ink("far_above"), "dot", "above 3 JND") +
          key("#8a8a8a", "line", "path in the time shown above") + "</p>\n<figure class=\"maps\">";
  for (const char* plane : {"xy", "xz", "yz"})
    html += fmt::format(
        "<canvas id=\"run-{0}\" role=\"img\" aria-label=\"errors in the plane {0}\"></canvas>", plane);
  return html +
         "<figcaption>Path of the tip, the box of states (dotted) and the samples, from three sides. The "
         "pointer "
         "reads a sample off and marks it above.</figcaption></figure>\n";
}

}  // namespace

std::string run_charts(const SessionResult& result, const RunView& view, const std::string& without_script) {
  if (result.frames.empty()) return "<p class=\"note\">No frame was rendered.</p>\n";
  const std::string compared = compared_in_words(result.frames);
  std::string data = run_data(result, view);
  for (std::size_t at = 0; (at = data.find("</", at)) != std::string::npos; at += 3)
    data.insert(at + 1, "\\");
  return curves(compared, result.loop.ending_frames) + around_switch(result.switches.size()) +
         maps(compared) + "<noscript>" + without_script +
         "</noscript>\n<script type=\"application/json\" id=\"run-data\">" + data + "</script>\n<script>\n" +
         std::string(run_script) + "</script>\n";
}

std::string worst_moments(const SessionResult& result, const RunView& view) {
  const std::vector<BadMoment> moments = bad_moments(result, view);
  if (moments.empty()) return "";
  std::string html =
      "<h2>Worst moments</h2>\n<div class=\"scroll\"><table class=\"moments\"><tr><th>time</th><th>error</th>"
      "<th>label</th><th>rendered</th><th>reference</th><th>tip [mm]</th><th>why</th></tr>\n";
  for (const BadMoment& m : moments)
    html += fmt::format(
        "<tr><td><button data-moment=\"{0:.6g}\">{0:.3f} s</button></td><td class=\"n\">{1:.3g} %<br>{2:.2g} "
        "× "
        "JND</td><td>{3}</td><td class=\"n\">{4:.3g} N</td><td class=\"n\">{5:.3g} N</td><td "
        "class=\"n\">{6:.3g}, "
        "{7:.3g}, {8:.3g}</td><td>{9}</td></tr>\n",
        m.t, 100 * m.error, m.jnds, name(m.label), m.rendered, m.reference, 1e3 * m.at[0], 1e3 * m.at[1],
        1e3 * m.at[2], html_escaped(m.why));
  return html +
         "</table></div>\n<p class=\"muted\">Samples above the just noticeable difference (JND), the worst "
         "first, at "
         "least 0.25 s apart. A button shows the moment in the curves below.</p>\n";
}

}  // namespace forefeel
