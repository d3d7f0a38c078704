#pragma once
// The records of a run: one for each frame, each dispatched solve and each model that the loop took. Plain
// data in SI units; `unknown` (NaN) marks a missing value.

#include <array>
#include <cstdint>
#include <string_view>

#include "geometry/common/types.hpp"
#include "geometry/coverage/coverage.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

// How the change from one model to the next affects the force in a frame (approx/switch/force_switch.hpp).
struct SwitchStep {
  std::uint32_t model = 0;       // serial number of the model that is rendered
  bool took_model = false;       // a newer model is rendered from this frame on
  Vec3 delta = Vec3::Zero();     // dF [N]
  double change = 0, bound = 0;  // |dF| and its limit by the rule [N]
  double motion_change = 0;      // |change of the force - dF|, due to the motion [N]
  double undamped_jump = 0;      // |f~' - f~| where a model is taken [N]
};

// For sampled frames: the force of a tight solve, and the errors of the rendered force. Errors are relative
// to max(|reference|, error_floor); judge/session_judge.hpp defines them.
struct Judgement {
  bool sampled = false;                              // by arc length
  bool first_visit = false;                          // of a lattice cell
  Vec3 reference = Vec3::Constant(unknown);          // [N]; of a viscous body: after the same filter
  Vec3 elastic_reference = Vec3::Constant(unknown);  // of a viscous body: before it [N]
  double error = unknown, approximation = unknown, switching = unknown, staleness = unknown;  // [1]
};

// Error bars: half-widths around the rendered force that contain the reference with a probability of 90, 95 and 99 %,
// and the error scale of the newest model (render/bar_link.hpp). Infinite while no model has states.
struct ForceBar {
  double scale = unknown;                                       // [N]
  std::array<double, 3> half_width{unknown, unknown, unknown};  // [N]
  // Of a model of energy jets: the force is that of jets within their trust, and their own estimate is within the
  // tolerance (approx/model/jet_set.hpp).
  bool trusted = false;
};

struct FrameTiming {             // real clock only
  double cost_us = unknown;      // of the frame's work [us]
  double lateness_us = unknown;  // of its start [us]
};

// How the tip touches a body that may be touched anywhere (touch/touch.hpp).
enum class TouchKind { none, stick, slip };
std::string_view name(TouchKind kind);

// The touch in a frame; none where the contact has one place.
struct TouchRecord {
  bool applies = false;  // the body may be touched anywhere
  TouchKind kind = TouchKind::none;
  bool inside = false;         // the tip, of the body at rest
  SurfacePlace site = {};      // none without a touch
  double tip_change = 0;       // of the force by the tip's way, were the site to stay [N]
  Vec3 normal = Vec3::Zero();  // mean normal under the pad
  double energy = 0;           // stored by body and pad [J]
  double lost = 0;             // by sliding, and at the end of a touch, in this frame [J]
  double slope = unknown;      // |g| / (f . n), g of touch/touch.hpp [1]
  bool at_border = false;      // the slide ended at a clamped facet
  bool snaps = false;          // the slide is not at its end yet
};

struct FrameRecord {
  double t = 0;                  // [s]
  Vec3 at = Vec3::Zero();        // of the HIP [m]: from rest; in the axes of the mesh where touched anywhere
  Vec3 force = Vec3::Zero();     // as rendered: by the switch, and of a viscous body after its filter [N]
  Vec3 elastic = Vec3::Zero();   // by the switch, before that filter [N]
  Vec3 sent = Vec3::Zero();      // after safety, to the device [N]
  Vec3 undamped = Vec3::Zero();  // of the newest model [N]
  Label label = Label::blank;    // at the HIP, from the states known in this frame
  std::uint32_t known = 0;       // number of known states
  SwitchStep step = {};
  Judgement judged = {};
  ForceBar bar = {};
  FrameTiming timing = {};
  TouchRecord touch = {};
};

// What is compared with Judgement::reference: the rendered force; of a viscous body that is touched anywhere, whose
// reference has no filter, that before it.
inline const Vec3& compared_force(const FrameRecord& frame) {
  return frame.touch.kind == TouchKind::none ? frame.force : frame.elastic;
}

enum class DispatchStatus {
  running,  // being solved when the run ended
  waiting,  // not begun when the run ended, its job was running
  solved,
  failed,
  arrived,    // known at a given time, without a solve
  preempted,  // cancelled during its solve
  withdrawn   // cancelled before its solve began
};
std::string_view name(DispatchStatus status);

// Why a state was dispatched.
struct DispatchChoice {
  double priority = 0;  // by the policy
  bool audit = false;   // not chosen by the policy: solved where the HIP was, to calibrate the error bars
  Vec3 site = Vec3::Constant(unknown);  // of the pad, where a body is touched anywhere [m]
};

struct DispatchRecord {
  std::uint32_t id = 0;
  Vec3 at = Vec3::Zero();  // of the HIP [m]
  Label label = Label::blank;
  DispatchChoice choice = {};
  double requested = unknown, started = unknown, finished = unknown, first_used = unknown;  // [s]
  double known = unknown;  // when the planner received the state: finished + a message [s]
  DispatchStatus status = DispatchStatus::running;
  int worker = -1;
  std::int64_t parent = -1;  // id of the row whose state the solve started from; -1: rest or a known state

  Vec3 displacement() const { return choice.site.allFinite() ? Vec3(at - choice.site) : at; }
};

enum class SwitchCause {
  guess,   // no state is known: the first guess
  first,   // the first state became known
  states,  // more states became known
  travel   // the HIP moved away from the model's position
};
std::string_view name(SwitchCause cause);

struct SwitchRecord {
  double t = 0;             // [s]
  std::uint32_t model = 0;  // serial number
  SwitchCause cause = SwitchCause::states;
  Label label = Label::blank;  // of the region that chose the model's states
  std::uint32_t n = 0;         // states of the model
  std::uint32_t replaced = 0;  // of these, not in the model before
  double jump_undamped = 0;    // |f~' - f~| at the HIP [N]
  double fit_us = unknown;     // real clock only [us]
};

}  // namespace forefeel
