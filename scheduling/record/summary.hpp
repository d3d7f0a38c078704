#pragma once
// The summary of a session as a type. Times are in s and forces in N unless the name says otherwise; shares
// are in [0, 1]. NaN: not measured. summary.json prints it and adds `attention` (record/attention.hpp),
// `spacing_auto` of the scene and `provenance` of the command.
//
//   const SessionPlan plan = make_plan(input, options);
//   PredictorScores scores(options.clock.frame);                       // only for motion.prediction
//   const SessionResult result =
//       run_session(plan, {.each_position = [&](const Vec3& at) { scores.add(at); }});
//   SessionSummary summary = summarise(result, plan);
//   summary.motion.prediction = scores.report();
//
// `rendered` has the same meaning in errors, plots and the columns rendered_x … of frames.csv: the force after the
// switch (and, for a viscous body, the relaxation filter), before the safety rules. `sent`, the columns fx, fy, fz, is
// the force after the safety rules (start-up ramp, force limit, slew limit …; render/safety.hpp). Energies are those of
// the sent force.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/coverage/coverage.hpp"
#include "scheduling/motion/prediction_score.hpp"
#include "scheduling/record/stability.hpp"
#include "scheduling/record/summary_parts.hpp"
#include "scheduling/session/session_options.hpp"

namespace forefeel {

struct SessionInput;
struct SessionPlan;

inline constexpr double felt_share = SwitchOptions{}.jnd_share;  // just noticeable difference, of the force

struct SessionSummary {
  // Nearest-rank quantiles of times per frame [us]; unknown under the virtual clock.
  struct Timing {
    double p50 = unknown, p99 = unknown, max = unknown;
  };
  // Timing of the render loop. A frame misses its deadline if cost and lateness together exceed its length.
  struct Deadline {
    std::size_t missed = 0;
    Timing cost_us, lateness_us;
  };
  // used: part of some model. wasted: solved but never used. inverted: solved, but with inverted elements;
  // they do not count as solved (geometry/states/state_outcome.hpp).
  struct States {
    std::size_t start = 0, solved = 0, used = 0, wasted = 0, preempted = 0, failed = 0, inverted = 0;
    // From the end of the solve to its first use [ms].
    double age_at_use_ms_p50 = unknown, age_at_use_ms_p99 = unknown;
    bool foreign = false;  // the states at the start are of another body; nothing was solved
  };
  // Effect of changing models. max_jump: largest |dF| in one frame. drift: largest |sum of dF| in any window
  // of 50, 100 or 300 ms.
  struct Switching {
    std::size_t count = 0;
    SwitchRule rule = SwitchRule::smooth;
    double max_jump = 0, max_jump_undamped = 0;
    std::size_t frames_over_jnd = 0;
    double drift_50ms = 0, drift_100ms = 0, drift_300ms = 0;
  };
  // Relative errors |F - f| / max(|f|, f0); within_jnd: share of the samples whose error is below the just
  // noticeable difference.
  struct Errors {
    std::size_t samples = 0;
    double p50 = unknown, p95 = unknown, max = unknown, within_jnd = unknown;
  };
  struct Parts {
    double approximation = unknown, switching = unknown, staleness = unknown;
  };
  // Error bars against the truth, over the samples that have a bar: the share whose |rendered - reference| is
  // inside, for each of bar_levels (approx/error/error_bar.hpp).
  struct Bars {
    std::size_t samples = 0;
    std::array<double, 3> inside{unknown, unknown, unknown};
    double width_p50 = unknown;       // median half-width of 95 % [N]
    double error_p95 = unknown;       // of |rendered - reference| [N]
    double width_over_p95 = unknown;  // their ratio
  };
  struct ErrorBars {
    Bars all;
    ByLabel<Bars> by_label;
    std::size_t without = 0;  // samples without a bar
    // Bars are at least a tenth of the just noticeable difference wide (render/bar_link.hpp): of all samples, those
    // with a bar at that floor, and the share inside of those above it, of each level.
    std::array<std::size_t, 3> at_floor{};
    std::array<double, 3> inside_above{unknown, unknown, unknown};
  };
  // The discretisation error of the body (solver/equilibrium/mesh_error.hpp). The caller measures it. The other errors
  // do not contain it.
  struct Mesh {
    double error = unknown;                // relative force
    std::size_t positions = 0;             // at which it was measured
    std::string how = "not measured";      // by what, or why not
    double low = unknown, high = unknown;  // an interval for error
    // Above the just noticeable difference and above the errors shown beside it.
    bool is_felt(double shown) const { return error > felt_share && !(error <= shown); }
  };
  // samples: positions at equal distances along the path. first_visit: the first frames in their lattice
  // cells.
  struct Error {
    Errors samples;
    Parts parts_p95, parts_p50;
    ByLabel<Errors> by_label;
    std::array<Errors, 2> by_trust;  // of frames without and with trust (ForceBar::trusted)
    double time_trusted = unknown;   // share of the frames with it; unknown: the models are not of jets
    Errors first_visit;
    ErrorBars bars;
    Mesh mesh;
  };
  struct Energy {
    double generated = 0, work = 0;  // [J]
    HandNumbers hand = {};
    std::optional<StabilityReport> stability = {};  // where the motion answers the force
    ControlSummary control = {};                    // where passivity is controlled
  };
  // Frames in which a safety rule acted, and two of these numbers as shares of all frames.
  struct Safety {
    std::size_t clamped = 0, slewed = 0, stale = 0, non_finite = 0;
    double clamped_share = 0, slewed_share = 0;
    // The limit behind `clamped`: the lower one of options and device [N]. Known only if the plan is given.
    double force_limit = unknown;
    FeltSteps felt = {};  // of the force that was sent
  };
  // Of a session whose states are of another body: how far the hand was from them, and the median 95 % error bars of
  // the force that they tell there and at the states themselves. Then the label under which they tell least: its share
  // of the frames, and the 95th percentile of the bars there (infinite: none can be given). The caller measures it.
  // rest_bar: the median bar of all other frames.
  struct AwayFromStates {
    double median = unknown, farthest = unknown;    // [m]
    double bar = unknown, bar_at_states = unknown;  // [N]
    Label worst = Label::blank;
    double worst_share = unknown, worst_bar = unknown, rest_bar = unknown;  // [1], [N], [N]
  };
  // The motion. start_…: force of a tight solve at the first frame, force rendered there, and time of the first sample
  // whose error is below the just noticeable difference [s] (unknown: there is none).
  struct Motion {
    double outside = 0;  // share of the frames outside the box of states; unknown: there is no box
    double start_reference = unknown, start_rendered = unknown, start_within_jnd = unknown;
    bool starts_wrong = false;  // the first frame's error is above the JND, at a reference above error_floor
    AwayFromStates away = {};
    std::optional<TouchNumbers> touch = {};  // none: one place of contact
    // Error of each registered predictor on this motion, if the caller measured it (PredictorScores).
    std::vector<PredictorErrors> prediction = {};
  };
  // Faults around the loop that did not stop it (scheduling/common/session_result.hpp, session/plausible.hpp). Skipped
  // frames and the actions of the safety rules are under Loop and Safety.
  struct Faults {
    std::size_t states_set_aside = 0, workers_lost = 0, planner_stalls = 0, clock_steps = 0;
    std::size_t device_held = 0, device_jumps = 0;  // frames
  };
  // Timing of the frames, and the end of the force (LoopReport of scheduling/common/session_result.hpp).
  struct Loop {
    std::size_t skipped = 0;
    double longest_pause = 0, planner_stall = 0;  // [s]; unknown under the virtual clock
    std::size_t ending_frames = 0;                // of the ramp at the end
    double last_force = 0;                        // |F| sent in the last frame [N]
    Faults faults = {};
  };
  // The settings of the session. A policy given as an object appears with the name that it returns.
  struct Settings {
    Clock clock = Clock::real;
    int workers = 0;
    std::string policy;
    Select select = Select::label;
    std::uint64_t seed = 0;
    double spacing = 0;     // of the states [m]
    std::string cost = {};  // of a solve, as written; empty under the real clock
    std::string device;     // "replay:RUN" where a run is replayed, "object" where an object was given
  };
  // How the run itself went.
  struct Run {
    double seconds = 0;  // of motion
    std::size_t frames = 0, frames_asked = 0;
    bool interrupted = false;         // ended early, or samples have no reference (RunEnd)
    bool first_guess = false;         // began with a guessed stiffness
    double guess_softness = unknown;  // against a half-space (equilibrium/first_guess.hpp)
    double wall_seconds = 0;
    bool realtime_priority = false, memory_locked = false;
    std::vector<std::string> notes;     // what the system refused, what failed
    std::vector<std::string> failures;  // what ended the session or lost results
  };

  Settings settings;
  Run run;
  Deadline deadline;
  States states;
  ByLabel<double> time_in;  // share of the frames
  Switching switching;
  Error error;
  double load = unknown;  // utilisation of the workers: states needed per second / states solved per second
  Energy energy;
  Safety safety;
  Loop loop;
  Motion motion;
};

SessionSummary summarise(const SessionResult& result, const SessionPlan& plan);
// The same from the input and options of the plan. safety.force_limit is then unknown, and frames_asked follows from
// options.clock.seconds, whatever the length of the motion.
SessionSummary summarise(const SessionResult& result, const SessionInput& input,
                         const SessionOptions& options);

}  // namespace forefeel
