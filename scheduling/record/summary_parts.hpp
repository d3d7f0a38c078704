#pragma once
// Parts of a summary (summary.hpp): what was known within a tolerance, passivity control, touches.
//
// Share of the frames of a session whose force was known within a tolerance (geometry/common/tolerance.hpp) according
// to its error bars, and how often this was true. A frame counts as known if the half-width of the bar of 95 % around
// its rendered force F [N] is at most limit(F). This was true if |F - f| <= limit(f), with f [N] the force of a tight
// solve. For a viscous body, F and f are the elastic forces.

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "scheduling/common/session_result.hpp"

namespace forefeel {

struct Tolerance;  // geometry/common/tolerance.hpp

struct ToleranceShare {
  std::size_t frames = 0, frames_known = 0;
  std::size_t samples = 0, known = 0, known_true = 0, within = 0;  // frames with f; within: of all samples
};

ToleranceShare tolerance_share(const SessionResult& result, const Tolerance& tolerance);

// Summarises the passivity control of a session, and the force error that it added in each frame:
//   e = |F - F'| / max(|F'|, f0)     [1]
// F [N]: force sent, F' [N]: force that the other safety rules alone would have sent at the same positions, f0 [N]: the
// error floor of the session. The ramp at the end is left out.

struct ControlSummary {
  PassivityReport report;
  double coupled_share = unknown, drained_share = unknown, controlled_share = unknown;  // of the frames
  double added_p50 = unknown, added_p95 = unknown, added_max = unknown;                 // e [1]
};

// sent: F of each frame but those of the ramp at the end.
ControlSummary control_summary(const SafetyReport& safety, std::span<const Vec3> sent, std::size_t frames,
                               double error_floor);
ControlSummary control_summary(const SessionResult& result, double error_floor);

// The part of a summary that is about touches of a body that may be touched anywhere.

struct TouchTask;

// Jets at rest that were made at the hand's place; they are counted apart from states.
bool is_jet_at_rest(const DispatchRecord& dispatch);
std::size_t jets_at_rest(const SessionResult& result);  // solved ones

TouchNumbers touches_of(const SessionResult& result, const TouchTask& task);
// "site was out of the cone of friction, catching up, for 3 % of the time in touch, up to 0.05 s on end".
std::string out_of_cone_in_words(const TouchNumbers& touch);

// Steps of the force that a hand feels, and what caused each (felt_steps.hpp).
enum class FeltCause { change_of_model, slip, snap, begin, end, motion };
inline constexpr std::array<FeltCause, 6> all_felt_causes{
    FeltCause::change_of_model, FeltCause::slip, FeltCause::snap,
    FeltCause::begin,           FeltCause::end,  FeltCause::motion};
std::string_view name(FeltCause cause);  // "switch", "slip" …

struct FeltSteps {
  std::size_t count = 0;
  double largest = 0, largest_share = 0;        // [N], [1]
  double largest_within = 0, share_within = 0;  // of those that neither begin nor end a touch
  std::array<std::size_t, all_felt_causes.size()> by_cause{};
};
// "2 steps of the force that a hand feels, the largest 0.21 N (5 %): 2 by a slip; beside 1 by the end of a touch". A
// touch that begins or ends under force is felt, and should be.
std::string in_words(const FeltSteps& steps);

}  // namespace forefeel
