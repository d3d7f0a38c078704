#pragma once
// A headless haptic session: workers solve states, the planner decides and updates models, a 1 kHz loop renders.
// Both clocks run the same Planner and the same RenderLoop; only who calls them when differs.

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "approx/select/updater.hpp"
#include "approx/switch/force_switch.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/policy/policy.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

class MpiGroup;

class ReferenceService;
struct ReferenceOptions;

enum class Clock { real, virtual_time };

struct SessionOptions {
  Clock clock = Clock::real;
  double seconds = 20;
  std::string device = "path:press,speed=0.06";
  std::string policy = "coverage";
  int workers = 2;  // solver workers, simulated ones under the virtual clock
  int threads = 0;  // real threads; never changes a virtual run's result
  SwitchOptions switching;
  ModelOptions model;
  std::string method =
      "rbf";  // or trilinear, tricubic: the lattice cell around the HIP, as before RBF models
  std::string placement =
      "lattice";                // where states may be placed: lattice, adaptive or path (candidates.hpp)
  double update_travel = 0.25;  // HIP travel that triggers an update, in spacings
  std::string cost = "constant:0.01";  // virtual clock: constant:S, lognormal:MEDIAN,SIGMA, recorded, paper
  double latency = 0;                  // per message [s]
  std::optional<std::filesystem::path>
      arrivals;  // CSV t,x,y,z, rows in any order: states become known at given times
  std::optional<std::filesystem::path> replay;  // a run folder: HIP and arrivals as recorded there
  bool preempt = true;
  // The first job of a session that knows nothing is the state at rest: its force is zero, its stiffness one factorisation
  // (cost.hpp), so that it is there long before any other, and the first model is the body's tangent at rest.
  bool rest_first = true;
  // Rest is known from the start: its force is zero, its stiffness comes from one factorisation before the first frame. The
  // hand then feels the body's tangent at once, and nothing has to fade in from zero.
  bool rest_known = false;
  // While nothing is known the hand feels the stiffness that a disc on a half-space of the body's material would have
  // (solver/body/contact_stiffness.hpp): no solve, no state. The first true state replaces it, faded in like any newer model.
  // Not where states come from files, nor where some are known from the start.
  bool first_guess = true;
  Mat3 guess = Mat3::Zero();  // that stiffness [N/m], by run_session(); zero: none
  // States of one job: the chosen one and its neighbours on its factor, 1 to 8; 0: 8 in real time and 1 under the virtual
  // clock, whose cost models know single solves. There each neighbour is taken to cost batch_share of a solve of its own
  // (0.4 to 0.6 measured on bodies of 1.7 and 8 thousand tetrahedra).
  int batch = 0;
  double batch_share = 0.5;
  std::shared_ptr<MpiGroup> mpi;     // real clock: its other ranks are the workers; null: threads
  std::string predictor = "kalman";  // or constant-velocity
  std::uint64_t seed = 0;
  double frame = 1e-3;            // [s]
  double error_floor = 0.05;      // f0 [N]
  double reference_step = 0.002;  // HIP travel between reference samples [m]
  double visit_cell = 0;          // side of the cells whose first visits are sampled [m]; 0: the spacing
  int visit_stride = 1;           // of the first visits every so many-th, from the first on
  double force_limit =
      12;  // safety clamp [N]: that of an omega.3; a device with a profile lowers it to its own
  double slew_limit = 1000;                        // [N/s]
  double ramp_seconds = 0.1;                       // start-up
  const std::atomic<bool>* interrupted = nullptr;  // once true, the session ends after that frame
  const std::atomic<bool>* hurried =
      nullptr;                 // once true, an interrupted run waits for no reference any more
  double patience = 3;         // with what is still to be solved for the references of an interrupted run [s]
  double stale_seconds = 0.5;  // watchdog: no sign of the planner for so long fades the force out
};

struct SessionInput {
  std::shared_ptr<const Body> body;
  BodyIdentity identity;
  StateSpaceOptions space;
  bool displacements = false;
  std::vector<State> known;                         // states at the start
  std::optional<std::filesystem::path> state_file;  // where new states are appended
  std::filesystem::path cache_folder;               // tight reference solves of this body; empty: none
  // One service for many sessions of the same body, spacing and displacements, also at the same time, since a cache
  // file has one writer; null: one of its own in cache_folder.
  std::shared_ptr<ReferenceService> references = {};
  std::filesystem::path scene_folder;
  Vec3 inward = -Vec3::UnitZ();
};

// What a service of reference solves needs to know of this input.
ReferenceOptions reference_options(const SessionInput& input);

struct FrameRecord {
  double t = 0;
  // force: as rendered by the switch; sent: after safety, what the device gets; undamped: of the newest model.
  Vec3 at = Vec3::Zero(), force = Vec3::Zero(), sent = Vec3::Zero(), undamped = Vec3::Zero();
  Label label = Label::blank;
  std::uint32_t model = 0, known = 0;
  bool took_model = false;
  Vec3 switch_delta = Vec3::Zero();                               // dF [N]
  double switch_change = 0, switch_bound = 0, motion_change = 0;  // |dF|, its bound, |change - dF| [N]
  double undamped_jump = 0;                                       // |f~' - f~| where a model is taken [N]
  double cost_us = unknown, lateness_us = unknown;                // real clock
  Vec3 reference = Vec3::Constant(unknown);                       // where sampled
  double error = unknown, approximation = unknown, switching = unknown, staleness = unknown;
  bool first_visit = false;  // of a lattice cell
  bool sampled = false;      // by arc length
};

struct DispatchRecord {
  std::uint32_t id = 0;
  Vec3 at = Vec3::Zero();
  Label label = Label::blank;
  double priority = 0;
  double requested = unknown, started = unknown, finished = unknown, first_used = unknown;  // [s]
  double known = unknown;  // when the planner had it: finished and a message [s]
  // solved, failed, arrived, preempted, withdrawn (cancelled before it began); at the end also running, and waiting for
  // others of its job
  std::string status = {};
  int worker = -1;
  std::int64_t parent = -1;  // id of the row whose state it started from, -1: rest or a state of the start
};

struct SwitchRecord {
  double t = 0;
  std::uint32_t model = 0;
  std::string cause = {};  // "states", "travel", "first"
  Label label = Label::blank;
  std::uint32_t n = 0, replaced = 0;
  double jump_undamped = 0;  // [N]
  double fit_us = unknown;   // real clock only
};

struct SessionResult {
  std::vector<FrameRecord> frames;
  std::vector<DispatchRecord> dispatch;
  std::vector<SwitchRecord> switches;
  std::vector<State> states;  // all known at the end, those of the start first
  double wall_seconds = 0;  // of the session, its labels and its references; not of reading and writing files
  bool realtime_priority = false, memory_locked = false, interrupted = false;
  bool not_begun = false;          // interrupted while the clairvoyant policy rehearsed: no frames, no solves
  std::vector<std::string> notes;  // what the system did not permit, what failed
  std::vector<std::string> warnings;  // of files that were read, one line each
  // scheduling/record/summary.hpp derives what summary.json holds from the above.
  std::array<std::size_t, 3> start_solved_failed{};
  std::size_t preempted = 0;
  double generated_energy = 0, work = 0;  // energy observer [J]
  std::size_t clamped = 0, slewed = 0, stale = 0, non_finite = 0;
  std::vector<double> solve_seconds;  // of each solve of the session but rest first, virtual or real
  std::size_t jobs = 0;               // that these came in; each took its worker two messages more
  int workers = 0;                    // that took part
};

struct SessionProgress {
  double t = 0, seconds = 0;
  std::size_t known = 0, solved = 0;
  Label label = Label::blank;
  double force = 0;
  std::string phase;  // "session", "labels", "references"
};

// Throws what run_session() would throw for input that cannot be run (unknown names, a bad trace, no workers …);
// solves and writes nothing.
void check_session(const SessionInput& input, const SessionOptions& options);
// Where the device ends by itself (a trace, a replay), its end [s]; infinite otherwise.
double motion_seconds(const SessionInput& input, const SessionOptions& options);

// when_run: called once after the last frame, before labels and errors are entered, which change `frames`, `switches`
// and `notes`; the result moves, so nothing may refer to it later.
// each_position: where the HIP was in each frame, in order, on a thread of its own and beside the run where that can be.
SessionResult run_session(const SessionInput& input, const SessionOptions& options,
                          const std::function<void(const SessionProgress&)>& progress = {},
                          const std::function<void(const SessionResult&)>& when_run = {},
                          const std::function<void(const Vec3&)>& each_position = {});

}  // namespace forefeel
