#include "scheduling/record/felt_steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/common/counted.hpp"

namespace forefeel {
namespace {

constexpr double slack = 1e-6;  // of the threshold and of the window

bool touches(const FrameRecord& frame) {
  return frame.touch.kind != TouchKind::none;
}

double explained(const FrameRecord& frame) {
  const double change = frame.touch.applies ? frame.touch.tip_change : frame.step.motion_change;
  return std::isfinite(change) ? change : 0;
}

// Frames first < j <= last.
struct Window {
  std::size_t first = 0, last = 0;
  double change = 0, share = 0;  // N, and over the larger force
  bool felt = false;
};

Window seen(std::span<const FrameRecord> frames, std::size_t first, std::size_t last, const FeltRule& rule) {
  const Vec3 &before = frames[first].sent, &after = frames[last].sent;
  const double size = std::max(before.norm(), after.norm());
  Window window{.first = first, .last = last, .change = (after - before).norm()};
  for (std::size_t j = first + 1; j <= last; ++j) window.change -= explained(frames[j]);
  window.share = size > 0 ? window.change / size : 0;
  window.felt = window.change > (1 + slack) * std::max(rule.share * size, rule.floor);
  return window;
}

FeltCause cause_of(std::span<const FrameRecord> frames, const Window& window, const FeltRule& rule,
                   std::size_t ending) {
  bool begins = frames[window.first].t < rule.start_up, ends = window.last + ending >= frames.size();
  bool snaps = false, slips = false;
  double switched = 0;
  for (std::size_t j = window.first + 1; j <= window.last; ++j) {
    const FrameRecord &frame = frames[j], &before = frames[j - 1];
    begins = begins || (touches(frame) && !touches(before));
    ends = ends || (!touches(frame) && touches(before));
    snaps = snaps || frame.touch.snaps;
    slips = slips || frame.touch.kind == TouchKind::slip;
    switched += frame.step.change;
  }
  if (ends) return FeltCause::end;
  if (begins) return FeltCause::begin;
  if (snaps) return FeltCause::snap;
  if (switched >= 0.5 * window.change) return FeltCause::change_of_model;
  return slips ? FeltCause::slip : FeltCause::motion;
}

std::string_view in_words(FeltCause cause) {
  constexpr std::string_view words[] = {"a switch of models",
                                        "a slip",
                                        "a snap",
                                        "the beginning of a touch or of the session",
                                        "the end of a touch or of the session",
                                        "the motion"};
  return words[static_cast<std::size_t>(cause)];
}

}  // namespace

std::string_view name(FeltCause cause) {
  constexpr std::string_view names[] = {"switch", "slip", "snap", "begin", "end", "motion"};
  return names[static_cast<std::size_t>(cause)];
}

FeltRule felt_rule(const SwitchOptions& switching, const SafetyOptions& safety) {
  return {.share = switching.jnd_share, .floor = switching.jnd_floor, .start_up = safety.ramp_seconds};
}

std::vector<FeltStep> felt_steps(std::span<const FrameRecord> frames, const FeltRule& rule,
                                 std::size_t ending) {
  std::vector<FeltStep> steps;
  const double width = rule.window * (1 - slack);
  bool running = false;
  for (std::size_t first = 0, last = 1; last < frames.size(); ++last) {
    while (first + 1 < last && frames[last].t - frames[first + 1].t >= width) ++first;
    if (frames[last].t - frames[first].t < width) continue;  // the session is younger than a window
    const Window window = seen(frames, first, last, rule);
    if (window.felt) {
      if (!running) steps.push_back({});
      FeltStep& step = steps.back();
      step.share = std::max(step.share, window.share);
      if (window.change > step.change)
        step.t = frames[last].t, step.change = window.change,
        step.cause = cause_of(frames, window, rule, ending);
    }
    running = window.felt;
  }
  return steps;
}

namespace {
bool begins_or_ends(FeltCause cause) {
  return cause == FeltCause::begin || cause == FeltCause::end;
}
}  // namespace

FeltSteps counted_steps(std::span<const FeltStep> steps) {
  FeltSteps felt{.count = steps.size()};
  for (const FeltStep& step : steps) {
    felt.largest = std::max(felt.largest, step.change);
    felt.largest_share = std::max(felt.largest_share, step.share);
    if (!begins_or_ends(step.cause)) {
      felt.largest_within = std::max(felt.largest_within, step.change);
      felt.share_within = std::max(felt.share_within, step.share);
    }
    ++felt.by_cause[static_cast<std::size_t>(step.cause)];
  }
  return felt;
}

FeltSteps felt_steps_of(const SessionResult& result, const FeltRule& rule) {
  return counted_steps(felt_steps(result.frames, rule, result.loop.ending_frames));
}

std::string in_words(const FeltSteps& steps) {
  std::size_t within = 0;
  std::string causes, ends;
  for (const FeltCause cause : all_felt_causes) {
    const std::size_t n = steps.by_cause[static_cast<std::size_t>(cause)];
    const bool end = begins_or_ends(cause);
    std::string& text = end ? ends : causes;
    if (n > 0) text += fmt::format("{}{} by {}", text.empty() ? "" : ", ", n, in_words(cause));
    within += end ? 0 : n;
  }
  std::string all = counted(within, "step") + " of the force that a hand feels";
  if (within > 0)
    all += fmt::format(", the largest {:.2g} N ({:.3g} %): {}", steps.largest_within,
                       100 * steps.share_within, causes);
  return ends.empty() ? all : all + "; apart from these " + ends;
}

}  // namespace forefeel
