#include "apps/session/run_charts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "apps/console/json.hpp"
#include "apps/picture/page.hpp"
#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"
#include "apps/session/bad_moments.hpp"
#include "geometry/common/base64.hpp"
#include "geometry/common/counted.hpp"
#include "scheduling/record/summary.hpp"

namespace forefeel {

namespace {

using Json = nlohmann::ordered_json;
using Frames = std::span<const FrameRecord>;

constexpr std::size_t most_frames = 60'000;

// Four digits are enough for a picture.
Json rounded(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0) return 0.0;
  const double step = std::pow(10, std::floor(std::log10(std::abs(value))) - 4);
  return std::round(value / step) * step;
}

Json moment(double t) {  // to 0.1 ms
  return std::round(1e4 * t) / 1e4;
}

// One column behind the other: time, |rendered|, |sent|, |newest model|, x, y, z, 95 % error bar (-1: none).
std::string columns_of(Frames frames, std::size_t every) {
  std::vector<float> values;
  const auto add = [&](auto value) {
    for (std::size_t i = 0; i < frames.size(); i += every) {
      const double v = value(frames[i]);
      values.push_back(std::isfinite(v) ? static_cast<float>(v) : 0.0f);
    }
  };
  add([](const FrameRecord& f) { return f.t; });
  add([](const FrameRecord& f) { return f.force.norm(); });
  add([](const FrameRecord& f) { return f.sent.norm(); });
  add([](const FrameRecord& f) { return f.undamped.norm(); });
  for (int axis = 0; axis < 3; ++axis) add([axis](const FrameRecord& f) { return f.at[axis]; });
  add([](const FrameRecord& f) {
    const double bar = f.bar.half_width[1];
    return std::isfinite(bar) ? bar : -1.0;
  });
  return base64(values);
}

// [time, value] where the value changes.
template <class Value>
Json changes(Frames frames, Value value) {
  Json list = Json::array();
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (i == 0 || value(frames[i]) != value(frames[i - 1]))
      list.push_back({moment(frames[i].t), value(frames[i])});
  return list;
}

// [begin, end] of the times in which the rendered force is above the limit.
Json clamped(Frames frames, double limit) {
  Json list = Json::array();
  if (!std::isfinite(limit)) return list;
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t end = i;
    while (end < frames.size() && frames[end].force.norm() > limit * (1 + 1e-6)) ++end;
    if (end > i)
      list.push_back({moment(frames[i].t), moment(end < frames.size() ? frames[end].t : frames.back().t)});
    i = std::max(end, i + 1);
  }
  return list;
}

// [t, |reference|, error, error in JNDs, its three parts, first visit, x, y, z]
Json samples(Frames frames, const RunView& view) {
  Json list = Json::array();
  for (const FrameRecord& f : frames) {
    const Judgement& j = f.judged;
    if (!std::isfinite(j.error)) continue;
    Json row{moment(f.t), rounded(j.reference.norm()), rounded(j.error), rounded(times_jnd(f, view))};
    for (const double part : {j.approximation, j.switching, j.staleness}) row.push_back(rounded(part));
    row.push_back(j.first_visit ? 1 : 0);
    for (const double x : f.at) row.push_back(rounded(x));
    list.push_back(std::move(row));
  }
  return list;
}

Json switches(std::span<const SwitchRecord> all) {
  Json list = Json::array();
  for (const SwitchRecord& s : all)
    list.push_back(
        {moment(s.t), s.model, name(s.cause), name(s.label), s.n, s.replaced, rounded(s.jump_undamped)});
  return list;
}

// The ink of a cause.
constexpr std::pair<FeltCause, const char*> felt_inks[] = {{FeltCause::change_of_model, "switching"},
                                                           {FeltCause::slip, "approximation"},
                                                           {FeltCause::snap, "group"},
                                                           {FeltCause::begin, "within"},
                                                           {FeltCause::end, "above"},
                                                           {FeltCause::motion, "clamp"}};

// [t, |force sent|, change, share, cause]
Json felt(const SessionResult& result, const RunView& view) {
  Json list = Json::array();
  for (const FeltStep& step : felt_steps(result.frames, view.felt, result.loop.ending_frames)) {
    const auto frame = std::ranges::lower_bound(result.frames, step.t, {}, &FrameRecord::t);
    list.push_back({moment(step.t), rounded(frame->sent.norm()), rounded(step.change), rounded(step.share),
                    name(step.cause)});
  }
  return list;
}

Json corners(const Vec3& low, const Vec3& high) {
  return Json::array({Json::array({low[0], low[1], low[2]}), Json::array({high[0], high[1], high[2]})});
}

// Colours by what the script calls them.
Json inks() {
  Json out{{"newest", ink("undamped")}, {"reference", ink("reference_light")}};
  for (const char* meaning : {"rendered", "sent", "limit", "approximation", "switching", "staleness", "bar",
                              "within", "above", "far_above"})
    out[meaning] = ink(meaning);
  for (const auto& [cause, meaning] : felt_inks) out["felt"][std::string(name(cause))] = ink(meaning);
  return out;
}

}  // namespace

std::string run_data(const SessionResult& result, const RunView& view) {
  const Frames frames = result.frames;
  const std::size_t every = frames.size() / most_frames + 1;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  for (const FrameRecord& f : frames) {
    low = low.cwiseMin(f.at);
    high = high.cwiseMax(f.at);
  }
  Json document{{"frames", (frames.size() + every - 1) / every},
                {"end", frames.empty() ? 0.0 : frames.back().t},
                {"limit", rounded(view.force_limit)},
                {"box", corners(view.box.low, view.box.high)},
                {"reach", corners(low, high)},
                {"ink", inks()}};
  for (const Label label : all_labels) {
    document["names"].push_back(name(label));
    document["colours"].push_back(colour(label));
  }
  document["labels"] = changes(frames, [](const FrameRecord& f) { return static_cast<int>(f.label); });
  document["known"] = changes(frames, [](const FrameRecord& f) { return f.known; });
  document["models"] = changes(frames, [](const FrameRecord& f) { return f.step.model; });
  document["clamped"] = clamped(frames, view.force_limit);
  document["samples"] = samples(frames, view);
  document["switches"] = switches(result.switches);
  document["felt"] = felt(result, view);
  document["columns"] = columns_of(frames, every);
  return json_text(document);
}

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
  return fmt::format("{}{}", counted(samples, "sample"),
                     visits > 0 ? fmt::format(", {} more at first visits", visits) : "");
}

std::string curves(const std::string& compared, const FeltSteps& felt, std::size_t ending_frames) {
  std::string html = fmt::format("<h2>Force, label and error over time ({})</h2>\n", compared);
  html += "<p class=\"legend\">" + key(ink("rendered"), "line", "rendered, before the safety rules") +
          key(ink("sent"), "dash", "sent to the device") + key(ink("limit"), "dash", "force limit") +
          key(ink("limit") + "33", "box", "clamped") +
          key(ink("undamped"), "line", "newest model, undamped") +
          key(ink("reference_light"), "dot", "reference") + key(ink("bar") + "2e", "box", "error bar, 95 %") +
          "</p>\n<p class=\"legend\"><span>step that a hand feels, by</span>";
  for (const auto& [cause, meaning] : felt_inks)
    html += key(ink(meaning), "box", std::string(name(cause)).c_str());
  html += "</p>\n<p class=\"muted\">Felt: " + in_words(felt) +
          ". Counted are changes within 10 ms beyond what the motion explains.</p>\n<p "
          "class=\"legend\"><span>error:</span>" +
          key(ink("rendered"), "line", "rendered") + key(ink("approximation"), "dot", "approximation") +
          key(ink("switching"), "dot", "switch") + key(ink("staleness"), "dot", "staleness") +
          key("#6a6a6a", "dash", "just noticeable") + "</p>\n";
  html +=
      "<figure><p class=\"bar\"><button id=\"run-all\">whole run</button><button id=\"run-in\">+</button>"
      "<button id=\"run-out\">−</button><button id=\"run-here\">switch at the pointer</button>"
      "<span class=\"muted\">Wheel: zoom. Drag: move. Pointer: read off. Keys: ← → + − 0.</span></p>\n"
      "<canvas id=\"run-time\" tabindex=\"0\" role=\"img\" aria-label=\"force, label, switches, error and "
      "known "
      "states over time\" style=\"height:560px\"></canvas>\n<p id=\"run-read\" class=\"read\"></p>\n";
  const std::string end = ending_frames > 0
                              ? fmt::format(
                                    "; in the last {} it shrinks to zero, as fast as the slew limit "
                                    "allows, because the session ends",
                                    counted(ending_frames, "frame"))
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
      "<div{}><h2>Around one switch ({} in all)</h2>\n<figure><p class=\"bar\"><button "
      "id=\"run-before\">‹</button>"
      "<input id=\"run-which\" type=\"range\" min=\"0\" value=\"0\" aria-label=\"number of the switch\">"
      "<button id=\"run-next\">›</button><button id=\"run-largest\">largest</button></p>\n"
      "<p id=\"run-what\"></p>\n<canvas id=\"run-switch\" role=\"img\" aria-label=\"force around one "
      "switch\" "
      "style=\"height:290px\"></canvas>\n<figcaption>60 ms before to 140 ms after the switch (dotted). The "
      "rendered "
      "force leaves the old model and reaches the newest without a step that a hand "
      "feels.</figcaption></figure></div>\n",
      switches == 0 ? " hidden" : "", switches);
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
  return curves(compared, felt_steps_of(result, view.felt), result.loop.ending_frames) +
         around_switch(result.switches.size()) + maps(compared) + "<noscript>" + without_script +
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
