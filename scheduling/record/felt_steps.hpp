#pragma once
// Steps of the force that a hand feels, counted from the frames of a session.
//
// A window holds the frames i < j <= k of 10 ms. In it the force sent F [N] changes by more than the motion explains by
//   N = |F_k - F_i| - sum over j of m_j      [N]
// m_j is what the model's stiffness makes of the tip's way in frame j, |integral of K dx|, taken from the model itself
// as a difference of its forces: at one place of contact SwitchStep::motion_change; of a body touched anywhere
// TouchRecord::tip_change, whose site stays where it was, so that a slide is no explanation. Where a site snaps the
// body moves by itself, and m_j = 0. Where a touch begins, the way counts from the place where the tip crossed the
// surface.
// The window is felt if N > max(share max(|F_i|, |F_k|), floor), the just noticeable difference of the larger force.
// Overlapping windows are one step: a step is a run of felt windows, counted once, with the largest N and the largest
// N / max(|F_i|, |F_k|) in it. A pause of the loop makes a window longer.
//
// Its cause is that of the window with the largest N; the first that applies:
//   end     a touch ended, or the frames are of the ramp at the end of the session
//   begin   a touch began, or the frames are of the start-up ramp
//   snap    a site had not come to rest (TouchRecord::snaps)
//   switch  changes by the switch are at least half of N
//   slip    a site slid
//   motion  what is left: the motion, the relaxation of a viscous body, or another safety rule

#include <cstddef>
#include <span>
#include <vector>

#include "scheduling/common/session_result.hpp"
#include "scheduling/record/summary_parts.hpp"
#include "scheduling/render/render_options.hpp"

namespace forefeel {

struct FeltRule {
  double share = SwitchOptions{}.jnd_share;        // [1]
  double floor = SwitchOptions{}.jnd_floor;        // [N]
  double window = SwitchOptions{}.paper_interval;  // [s]
  double start_up = SafetyOptions{}.ramp_seconds;  // [s]
};
FeltRule felt_rule(const SwitchOptions& switching, const SafetyOptions& safety);

struct FeltStep {
  double t = 0;       // end of the window with the largest N [s]
  double change = 0;  // that N [N]
  double share = 0;   // the largest N / max(|F_i|, |F_k|) [1]
  FeltCause cause = FeltCause::motion;
};

// In order of time. ending: frames of the ramp at the end (LoopReport::ending_frames).
std::vector<FeltStep> felt_steps(std::span<const FrameRecord> frames, const FeltRule& rule,
                                 std::size_t ending = 0);

FeltSteps counted_steps(std::span<const FeltStep> steps);
FeltSteps felt_steps_of(const SessionResult& result, const FeltRule& rule);

}  // namespace forefeel
