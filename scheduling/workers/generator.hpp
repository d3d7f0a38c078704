#pragma once
// The workers that solve states. The planner gives jobs to idle workers and may cancel them; results return
// to the planner.
//   Generator        the interface that the planner uses
//   RealWorkers      under the real clock: threads, other processes, other machines
//   VirtualWorkers   under the virtual clock: a discrete-event simulation, nothing runs
//
// To write a kind: derive from RealWorkers, VirtualWorkers or both, and register the classes under one name.
// A kind that lacks one of the two is refused under the corresponding clock.
//
//   struct Pool final : forefeel::RealWorkers { … };              // of its own threads
//   const bool known = (forefeel::register_workers("pool", {.real = [](forefeel::RealWorkersContext& with) {
//     return std::make_unique<Pool>(with.body, with.solving, with.count); }}), true);
//
// In code, options.workers.kind = Registered("pool") then selects it. Scenes, studies and options
// know the name only in a command built with it (apps/examples/command_policy.cpp); `forefeel` itself is not.
//
// Order of calls, real clock: begin() once; then dispatch(), cancel() and collect() from the planner's
// thread; at the end stop() and a last collect(). If serves() is true, the session starts a team of threads,
// and each calls serve() between begin() and stop(). collect() is called about every half millisecond and
// must not wait longer than its timeout. Order of calls, virtual clock, all from one thread: set_now() before
// each dispatch() and cancel(); next_event() after each step; take_event() when that event is the session's
// next one. Runs must repeat bit by bit: results must depend neither on wall time nor on the order of
// threads. A worker gets a job only while it is idle. Each state of a job returns one result, cancelled or
// not; with the last result the worker is idle again.

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"
#include "scheduling/common/arguments.hpp"

namespace forefeel {

class CostModel;
class ReferenceService;
class RestSites;
struct Body;
struct Equilibrium;

struct Job {
  struct Neighbour {
    std::uint32_t dispatch = 0;
    Vec3 at = Vec3::Zero();  // [m]
  };
  std::uint32_t dispatch = 0;  // row of dispatch.csv
  Vec3 at = Vec3::Zero();      // [m]
  SurfacePlace site = {};      // of the pad, where a body is touched anywhere; else none
  // Where to start: the nearest known solution, or the last iterate of a cancelled solve of this state. Null:
  // rest.
  std::shared_ptr<const Equilibrium> start;
  std::vector<Neighbour> beside = {};  // solved after it, reusing its factorisation
};

struct JobResult {
  std::uint32_t dispatch = 0;
  int worker = 0;
  double started = unknown, finished = unknown;  // session time [s]
  State state;                                   // cancelled: only the worker is released
  std::shared_ptr<const Equilibrium> equilibrium;
  std::shared_ptr<const Equilibrium> partial = {};  // cancelled: the last iterate
};

class Generator {
 public:
  virtual ~Generator() = default;
  virtual int workers() const = 0;                                // ready to take jobs; may grow
  virtual bool takes_jobs(int /*worker*/) const { return true; }  // false: it cannot be reached at present
  virtual void dispatch(int worker, Job job) = 0;                 // to an idle worker
  virtual void cancel(int worker) = 0;  // results still come: cancelled, or solved if too late
};

// Workers of the real clock.
class RealWorkers : public Generator {
 public:
  virtual void begin(std::function<double()> now) = 0;  // now(): session time [s], from any thread
  virtual bool serves() const { return false; }         // whether the session's threads must call serve()
  virtual void serve() {}  // runs one worker; returns after stop(). Does not throw
  // Puts the results since the last call into `out`, which is empty; waits up to `timeout` seconds for one. Each result
  // belongs to a dispatch of its worker; each dispatch gets one result.
  virtual void collect(std::vector<JobResult>& out, double timeout) = 0;
  virtual void stop() = 0;  // cancels running solves; collect() then returns the rest
  // Set if all workers have failed; else null. Nothing more is dispatched, and the session continues with the known
  // states.
  virtual std::exception_ptr failure() const = 0;
  virtual int lost() const {
    return 0;
  }  // how often a worker failed or could not be reached while others continued
  // After stop(): what the user should know about the workers, one line each.
  virtual std::vector<std::string> notes() const { return {}; }
};

// Workers of the virtual clock.
class VirtualWorkers : public Generator {
 public:
  using Time = std::chrono::nanoseconds;  // of the session
  virtual void set_now(Time now) = 0;
  virtual std::optional<Time> next_event() const = 0;  // not before now; nullopt: no job is running
  // Puts the results of the next event into `results`, which is empty. There are none if its job has been cancelled
  // since.
  virtual void take_event(std::vector<JobResult>& results) = 0;
};

struct StateSolverOptions {
  double spacing = 0.006;   // continuation step of the reference branch [m]
  double tolerance = 1e-6;  // of from()
  bool displacements = false;
  int jet = 1;  // order of the force that a state keeps: with 2 to 4 also an energy jet
  std::shared_ptr<const RestSites> sites = {};  // of a body that is touched anywhere: jobs have a site
};

struct RealWorkersContext {
  std::shared_ptr<const Body> body;
  StateSolverOptions solving = {};  // spacing, tolerance, what states keep
  int count = 1;                    // workers asked for
  Arguments arguments = {};         // the user's settings; empty for built-in kinds
};
struct VirtualWorkersContext {
  ReferenceService& references;  // gives values of states: request() early, get() when due
  const CostModel& cost;
  int count = 1;             // workers asked for
  bool rest_first = true;    // a job at rest is charged CostModel::rest_seconds()
  double batch_share = 0.5;  // share of its cost that a neighbour is charged
  double latency = 0;        // of a message to or from a worker [s]
  Arguments arguments = {};  // the user's settings; empty for built-in kinds
};

struct WorkersKind {
  std::function<std::unique_ptr<RealWorkers>(RealWorkersContext&)> real = {};
  std::function<std::unique_ptr<VirtualWorkers>(VirtualWorkersContext&)> simulated = {};
};

// May be called from any thread, and before main() begins. InputError for a name that is taken.
void register_workers(const std::string& name, WorkersKind kind);
std::vector<std::string> workers_names();  // sorted
// The workers of a name and its settings. Throws InputError for an unknown name (the error lists the known ones), and
// for a kind without workers for that clock.
std::unique_ptr<RealWorkers> make_real_workers(const Registered& workers, const RealWorkersContext& context);
std::unique_ptr<VirtualWorkers> make_virtual_workers(const Registered& workers,
                                                     const VirtualWorkersContext& context);
// Throws the same InputError as the two above, but makes no workers.
void check_workers(const Registered& workers, bool virtual_clock);

}  // namespace forefeel
