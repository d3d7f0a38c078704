#include "apps/session/session_screen.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <system_error>

#include "apps/console/look_at_it.hpp"
#include "geometry/common/counted.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/record/notes.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

std::string share(double value) {
  if (!std::isfinite(value)) return "unknown";
  return said_percent(value);
}

// One of the figures that a reader looks for: what it is, its value, its meaning.
void tell_figure(const Globals& globals, const char* what, const std::string& value,
                 const std::string& meaning) {
  say(globals, fmt::format("  {:<9} {:>12}  {}", what, value, meaning));
}

void tell_figures(const Globals& globals, const SessionSummary& s) {
  const SessionSummary::Errors &error = s.error.samples, &visits = s.error.first_visit;
  tell_figure(
      globals, "error", share(error.p95),
      fmt::format("of the force, for 95 % of the samples (median {}); below what a hand feels: {} samples, "
                  "{} first visits",
                  share(error.p50), share_of_samples(error.within_jnd, error.samples),
                  share_of_samples(visits.within_jnd, visits.samples)));
  const SessionSummary::Bars& bars = s.error.bars.all;
  if (bars.samples > 0)
    tell_figure(
        globals, "bars", share(bars.inside[1]),
        fmt::format("of {} true forces lay inside the 95 % error bars, of half-width {:.2g} N (median)",
                    bars.samples, bars.width_p50));
  tell_figure(
      globals, "safe", share(s.time_in[Label::safe]),
      fmt::format("of the time among densely known states; sparse {}, gap {}, blank {}{}",
                  share(s.time_in[Label::sparse]), share(s.time_in[Label::gap]),
                  share(s.time_in[Label::blank]),
                  std::isfinite(s.motion.outside) ? "; outside the box " + share(s.motion.outside) : ""));
  const std::string felt = in_words(s.safety.felt);
  const std::string behind = s.motion.touch && s.motion.touch->out_of_cone > 0
                                 ? "; the " + out_of_cone_in_words(*s.motion.touch)
                                 : "";
  const std::size_t noun = felt.find(' ') + 1;
  tell_figure(globals, "felt", felt.substr(0, noun - 1),
              fmt::format("{}; of {} changes of model {} moved it by more than their bound in a frame; "
                          "clamped {}, slewed {} of the frames{}",
                          felt.substr(noun), s.switching.count, s.switching.frames_over_jnd,
                          share(s.safety.clamped_share), share(s.safety.slewed_share), behind));
}

}  // namespace

void tell_session(const Globals& globals, const SessionSummary& s, const std::optional<std::string>& shapes,
                  const fs::path& run) {
  for (const std::string& line : attention(s)) say(globals, "attention: " + line);
  const std::string states =
      s.states.foreign
          ? fmt::format("of {} of another body; none was solved", counted(s.states.start, "state"))
          : fmt::format(
                "{} known at the start, {} solved by {} (policy {}{}{}){}, {} used",
                counted(s.states.start, "state"), s.states.solved,
                counted(static_cast<std::size_t>(s.settings.workers), "worker"), s.settings.policy,
                s.settings.cost.empty() ? "" : ", cost " + s.settings.cost,
                std::isfinite(s.load) ? fmt::format(", load {:.2g}", s.load) : "",
                s.states.inverted > 0 ? fmt::format(", {} with inverted elements", s.states.inverted) : "",
                s.states.used);
  say(globals,
      fmt::format("{:.3g} s rendered: {} ({} clock), {}; {}", s.run.seconds, counted(s.run.frames, "frame"),
                  s.settings.clock == Clock::real ? "real" : "virtual",
                  counted(s.deadline.missed, "missed deadline"), states));
  tell_figures(globals, s);
  if (shapes) say(globals, *shapes);
  for (const std::string& note : remarks(s)) say(globals, "note: " + note);
  for (const std::string& note : shortened_notes(s.run.notes)) say(globals, "note: " + note);
  if (std::error_code problem; fs::exists(run / "report.html", problem))
    say(globals, fmt::format("report: {}", (run / "report.html").string()));
  say(globals, look_at_it(globals, run));
}

}  // namespace forefeel
