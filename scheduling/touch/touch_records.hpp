#pragma once
// The records of a session in which a body is touched anywhere: one for each frame, each solve and each model that the
// loop took. Positions are in the axes of the mesh [m]; `unknown` (NaN) marks a missing value.

#include <cstdint>
#include <string>
#include <vector>

#include "approx/switch/force_switch.hpp"
#include "geometry/coverage/coverage.hpp"
#include "geometry/states/state.hpp"
#include "scheduling/common/records.hpp"
#include "scheduling/touch/touch.hpp"

namespace forefeel {

// The forces of a frame.
struct TouchForces {
  Vec3 elastic = Vec3::Zero();   // by the switch [N]
  Vec3 rendered = Vec3::Zero();  // of a viscous body after its filter; else the same [N]
  Vec3 sent = Vec3::Zero();      // after the safety rules [N]
  Vec3 undamped = Vec3::Zero();  // of the newest model [N]
};

// Where the force came from.
struct TouchSource {
  std::uint32_t model = 0, known = 0;  // serial number; states that it holds
  ForceBar bar;            // scale: its estimate of its error; judged after the run (touch_judge.hpp)
  double slope = unknown;  // |g| / (f . n), g of slip.hpp [1]; above mu where the clamp stopped the site
  bool at_border = false;  // that
};

struct TouchFrameRecord {
  double t = 0;             // [s]
  Vec3 tip = Vec3::Zero();  // [m]
  TouchKind touch = TouchKind::none;
  SurfacePlace site;            // valid unless none
  Vec3 normal = Vec3::Zero();   // mean normal there
  double energy = 0, lost = 0;  // stored; lost in this frame [J]
  TouchForces force;
  TouchSource source;
  SwitchStep step;
  Label label = Label::blank;
  Judgement judged;
  FrameTiming timing;
};

struct TouchDispatch {
  std::uint32_t id = 0;
  Vec3 site = Vec3::Zero(), x = Vec3::Zero();  // [m]; x = 0: a jet at rest
  double priority = 0;
  double requested = unknown, started = unknown, finished = unknown, known = unknown;  // [s]
  DispatchStatus status = DispatchStatus::running;
  int worker = -1;
};

std::string_view name(TouchKind kind);
// Of a judged frame: the error is at most the just noticeable difference.
bool is_within_jnd(const TouchFrameRecord& frame, const SwitchOptions& jnd);

}  // namespace forefeel
