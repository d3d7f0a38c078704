#pragma once
// The result of a session, and its progress while it runs. record/run_files.hpp writes the result to files;
// record/summary.hpp summarises it.

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "scheduling/common/records.hpp"

namespace forefeel {

struct StateCounts {
  std::size_t start = 0, solved = 0, failed = 0, preempted = 0;
  std::size_t set_aside =
      0;  // of the failed: solved, but not states of this body (scheduling/session/plausible.hpp)
};

// Interventions of the passivity control (render/passivity.hpp). Not filled if passivity is only observed.
struct PassivityReport {
  bool on = false;
  double coupling = 0;         // K_c: largest stiffness rendered [N/m]; infinite: no limit is known
  std::size_t coupled = 0;     // frames in which the coupling was softer than the body
  std::size_t drained = 0;     // frames in which the tank lowered the force
  std::size_t controlled = 0;  // frames in which the controller damped
  double least_gain = 1;       // least factor s g of coupling and tank together [1]
  double lowest = 0;  // least energy E + q of the tank [J]; below zero: the limits did not allow more damping
  double refused = 0;     // sum over switches of the energy that they would have generated [J]
  double dissipated = 0;  // energy taken by the controller [J]
};

// Interventions of the safety rules, and the work of the hand by the energy observer (render/safety.hpp).
struct SafetyReport {
  std::size_t clamped = 0, slewed = 0, stale = 0, non_finite = 0;  // frames
  double generated = 0;  // largest energy returned beyond that received [J]
  double work = 0;       // sum of |F . dx| [J]
  PassivityReport passivity = {};
  // By frame, under passivity control: the force that the other rules alone would have sent [N].
  std::vector<Vec3> uncontrolled = {};
};

// Timing of the frames, and the end of the force (render/loop_thread.hpp, render/render_loop.hpp).
struct LoopReport {
  std::size_t skipped = 0;         // frames that were late by a frame or more; they have no record
  double longest_pause = 0;        // between the starts of two frames [s]; virtual clock: 0
  double paused_at = 0;            // when it began [s]
  double planner_stall = 0;        // longest time between two steps of the planner [s]; virtual clock: 0
  std::size_t planner_stalls = 0;  // number of pauses longer than the watchdog allows
  std::size_t clock_steps = 0;     // of the system clock (render/loop_thread.hpp)
  std::size_t device_held = 0;     // frames in which the device's position was not finite
  std::size_t device_jumps = 0;    // frames in which it moved faster than SwitchOptions::jump_speed
  std::size_t ending_frames = 0;   // of the ramp at the end
  double last_force = 0;           // |F| sent in the last frame [N]
};

// What keeps a site from following the tip, most of the time that it is beyond (below).
enum class SiteHolder {
  friction,
  edge,  // kept by the smooth surface (solver/jet/smooth_surface.hpp), within the pad's radius
  clamp,
  lag,     // the slide is not at its end yet
  minimum  // of the energy
};

// Touches of a body that may be touched anywhere. Shares: `time` of the frames, `slipping`, `beyond` and `out_of_cone`
// of those in touch; beyond: the tip is farther from its site than any state is placed (touch/touch_field.hpp);
// out_of_cone: the slide is not at its end yet (TouchRecord::snaps).
struct TouchNumbers {
  std::size_t count = 0, jets = 0;  // that began; jets at rest that were made at the hand's place
  double time = unknown, slipping = unknown, beyond = unknown;
  double friction = unknown;              // coefficient; unknown: bonded
  double slid = 0, lost = 0, stored = 0;  // way of the site [m]; energy lost, the most that was stored [J]
  double cone = unknown;                  // |(|g| / f . n) - mu| / mu while sliding on a facet, the largest
  double out_of_cone = unknown, out_of_cone_longest = unknown;  // the longest time on end [s]
  double angle_p50 = unknown, angle_p95 = unknown;              // of the force to the normal [rad]
  SiteHolder holder = SiteHolder::friction;
};

struct SolverReport {
  std::vector<double> seconds;  // of each solve, virtual or real; without the first one at rest [s]
  std::size_t jobs = 0;         // number of jobs of these solves; each job also costs two messages
  int workers = 0;              // number that took part
  int lost = 0;                 // how often one of these failed or could not be reached
};

enum class RunEnd {
  whole,
  interrupted,  // ended early by the user or a failure, or samples without a reference
  not_begun     // interrupted during the rehearsals of a clairvoyant session: no frames
};

// How the run as a whole went.
struct RunReport {
  RunEnd end = RunEnd::whole;
  double wall_seconds = 0;          // session, labels and references; without file access [s]
  double guess_softness = unknown;  // of the plan (session/session_plan.hpp)
  bool viscous = false;             // the elastic force passed a relaxation function
  // Real clock only.
  bool realtime_priority = false;  // of the loop's thread
  bool memory_locked = false;
};

struct SessionResult {
  std::vector<FrameRecord> frames;
  std::vector<DispatchRecord> dispatch;
  std::vector<SwitchRecord> switches;
  std::vector<State> states;  // all known at the end; those known at the start come first
  StateCounts counts;
  SafetyReport safety;
  LoopReport loop;
  SolverReport solver;
  RunReport run;
  std::vector<std::string> notes;     // what the system refused, what failed
  std::vector<std::string> warnings;  // about input files and the cache, one line each
  // Failures that ended the session or lost results: a failing planner or worker, a full disk of the states' file.
  // One line each; the rest of the result is valid.
  std::vector<std::string> failures;
  bool interrupted() const { return run.end != RunEnd::whole; }
};

enum class SessionPhase { arrivals, session, labels, references };
std::string_view name(SessionPhase phase);

struct SessionProgress {
  SessionPhase phase = SessionPhase::session;
  double t = 0, seconds = 0;  // [s] in phase session; otherwise counts: done, total
  std::size_t known = 0, solved = 0;
  Label label = Label::blank;
  double force = 0;  // [N]
  // During the rehearsals of a clairvoyant session: number of the schedule, and of all. 0: no rehearsal.
  std::size_t rehearsal = 0, rehearsals = 0;
};
// "labels", or "rehearsal 2 of 7, labels".
std::string phase_in_words(const SessionProgress& progress);
using ShowProgress = std::function<void(const SessionProgress&)>;

}  // namespace forefeel
