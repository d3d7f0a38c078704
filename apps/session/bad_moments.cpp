#include "apps/session/bad_moments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace forefeel {
namespace {

constexpr double apart = 0.25;  // [s]

std::string millimetres(double metres) {
  return fmt::format("{:.3g} mm", 1e3 * metres);
}

double known_at(const DispatchRecord& d) {
  const bool came = d.status == DispatchStatus::solved || d.status == DispatchStatus::arrived;
  if (!came) return std::numeric_limits<double>::infinity();
  return std::isfinite(d.known) ? d.known : d.finished;
}

// Distance from the tip to the nearest state known at that moment; infinite where none was.
double nearest_known(const SessionResult& result, const FrameRecord& f) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(result.counts.start, result.states.size()); ++i)
    least = std::min(least, (result.states[i].tip() - f.at).norm());
  for (const DispatchRecord& d : result.dispatch)
    if (known_at(d) <= f.t) least = std::min(least, (d.at - f.at).norm());
  return least;
}

std::string known_words(const FrameRecord& f, double distance) {
  if (!std::isfinite(distance)) return "No state was known.";
  if (f.known == 1) return fmt::format("The only known state was {} away.", millimetres(distance));
  return fmt::format("The nearest of {} known states was {} away.", f.known, millimetres(distance));
}

// Tells a queue from a slow solve. Empty where a worker took the request at once.
std::string waiting_words(const DispatchRecord& d) {
  const double waited = d.started - d.requested;
  if (!(waited > 0.1 * (d.finished - d.started))) return "";
  return fmt::format(", waited {:.2g} s for a free worker, took {:.2g} s to solve", waited,
                     d.finished - d.started);
}

// Describes the nearest state within `distance` that became known only later, or never: when it was requested, and when
// it came.
std::string missing_words(const SessionResult& result, const FrameRecord& f, double distance) {
  const DispatchRecord* best = nullptr;
  for (const DispatchRecord& d : result.dispatch) {
    const double away = (d.at - f.at).norm();
    if (known_at(d) <= f.t || !(away < distance)) continue;
    if (!best || away < (best->at - f.at).norm()) best = &d;
  }
  if (!best) return "No nearer one was asked for, before or after.";
  const std::string place = fmt::format("A state {} away", millimetres((best->at - f.at).norm()));
  const double known = known_at(*best);
  const std::string asked = !std::isfinite(best->requested) ? std::string()
                            : best->requested <= f.t
                                ? fmt::format(" was asked for {:.2g} s before", f.t - best->requested)
                                : fmt::format(" was asked for {:.2g} s after", best->requested - f.t);
  if (std::isfinite(known))
    return place + asked + waiting_words(*best) + fmt::format(" and came {:.2g} s too late.", known - f.t);
  return place + asked + fmt::format(" and never came ({}).", name(best->status));
}

std::string part_words(const Judgement& j) {
  const double most =
      std::max({std::isfinite(j.approximation) ? j.approximation : 0,
                std::isfinite(j.switching) ? j.switching : 0, std::isfinite(j.staleness) ? j.staleness : 0});
  if (!(most > 0)) return "";
  if (most == j.approximation) return "Largest part: approximation, the states near the tip did not suffice.";
  if (most == j.staleness) return "Largest part: staleness, the model did not use states known by then.";
  return "Largest part: switch, the force was still on its way to the newest model.";
}

std::string why(const SessionResult& result, const FrameRecord& f, const RunView& view) {
  const double distance = nearest_known(result, f);
  std::string text = known_words(f, distance);
  const auto add = [&](const std::string& sentence) {
    if (!sentence.empty()) text += " " + sentence;
  };
  if (!view.box.contains(f.at)) add("The tip was outside the box: no state is placed there.");
  // A state within half a spacing is as near as the lattice allows.
  if (distance > 0.5 * view.spacing) add(missing_words(result, f, distance));
  add(part_words(f.judged));
  if (f.force.norm() > view.force_limit * (1 + 1e-6)) add("The force was clamped, too.");
  return text;
}

}  // namespace

std::vector<BadMoment> bad_moments(const SessionResult& result, const RunView& view, std::size_t most) {
  std::vector<const FrameRecord*> bad;
  for (const FrameRecord& f : result.frames)
    if (times_jnd(f, view) > 1) bad.push_back(&f);
  std::ranges::stable_sort(bad, std::greater<>(), [&](const FrameRecord* f) { return times_jnd(*f, view); });
  std::vector<BadMoment> moments;
  for (const FrameRecord* f : bad) {
    if (moments.size() >= most) break;
    if (std::ranges::any_of(moments, [&](const BadMoment& m) { return std::abs(m.t - f->t) < apart; }))
      continue;
    moments.push_back({.t = f->t,
                       .at = f->at,
                       .label = f->label,
                       .rendered = f->force.norm(),
                       .reference = f->judged.reference.norm(),
                       .error = f->judged.error,
                       .jnds = times_jnd(*f, view),
                       .why = why(result, *f, view)});
  }
  return moments;
}

}  // namespace forefeel
