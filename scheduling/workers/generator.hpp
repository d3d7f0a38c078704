#pragma once
// Who solves states: the planner hands jobs to idle workers and may cancel them; results come back to the planner.
//   Generator        what the planner sees of them
//   RealWorkers      under the real clock: threads, other processes, other machines
//   VirtualWorkers   under the virtual clock: nothing runs, the session goes from event to event
//
// To write a kind: derive from RealWorkers, from VirtualWorkers or from both, register them under one name. A kind that
// lacks one of the two is refused under that clock.
//
//   struct Pool final : forefeel::RealWorkers { … };              // of its own threads
//   const bool known = (forefeel::register_workers("pool", {.real = [](forefeel::RealWorkersContext& with) {
//     return std::make_unique<Pool>(with.body, with.solving, with.count); }}), true);
//
// Scenes (session.workers_kind), studies and --workers-kind then know it as "pool".
//
// Order of calls, real clock: begin() once; then from the planner's thread dispatch(), cancel() and collect(); at the end
// stop() and collect() once more. Where serves() is true the session starts a team of threads, each of which calls serve()
// between begin() and stop(). collect() is called about every half millisecond and must not wait longer than it was told.
// Order of calls, virtual clock, all from one thread: set_now() before each dispatch() and cancel(); next_event() after
// each step; take_event() where that event is the next of the session. Bits must repeat: no wall time, no threads' order.
// A worker gets a job only while it is idle. For each state of a job, one result comes back, cancelled or not; the worker
// is idle again with the last of them.

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scheduling/common/arguments.hpp"
#include "scheduling/workers/state_solver.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

class CostModel;
class ReferenceService;

struct Job {
  struct Neighbour {
    std::uint32_t dispatch = 0;
    Vec3 at = Vec3::Zero();  // [m]
  };
  std::uint32_t dispatch = 0;  // row of dispatch.csv
  Vec3 at = Vec3::Zero();      // [m]
  // Where to start: the nearest known solution, or where a solve of this state was broken off. Null: rest.
  std::shared_ptr<const Equilibrium> start;
  std::vector<Neighbour> beside = {};  // solved after it, on its factor
};

struct JobResult {
  std::uint32_t dispatch = 0;
  int worker = 0;
  double started = unknown, finished = unknown;  // session time [s]
  State state;                                   // status cancelled: nothing but the worker is given back
  std::shared_ptr<const Equilibrium> equilibrium;
  std::shared_ptr<const Equilibrium> partial = {};  // cancelled: where it stood
};

class Generator {
 public:
  virtual ~Generator() = default;
  virtual int workers() const = 0;                 // ready to take jobs; may grow
  virtual void dispatch(int worker, Job job) = 0;  // to an idle worker
  virtual void cancel(int worker) = 0;  // results still come: cancelled, or solved if it was too late
};

// Workers of the real clock.
class RealWorkers : public Generator {
 public:
  virtual void begin(std::function<double()> now) = 0;  // now(): session time [s], from any thread
  virtual bool serves() const { return false; }         // whether threads of the session are to call serve()
  virtual void serve() {}  // a worker's life; returns after stop(). Does not throw
  // Results since the last call; waits up to `timeout` seconds for one.
  virtual void collect(std::vector<JobResult>& out, double timeout) = 0;
  virtual void stop() = 0;  // running solves are cancelled; collect() once more for what is left
  virtual std::exception_ptr failure() const = 0;  // of a worker; null: none. The session then ends with it
};

// Workers of the virtual clock.
class VirtualWorkers : public Generator {
 public:
  using Time = std::chrono::nanoseconds;  // of the session
  virtual void set_now(Time now) = 0;
  virtual std::optional<Time> next_event() const = 0;  // not before now; nothing: no job is under way
  // The results of the next event, perhaps none: it was of a job that has been cancelled since.
  virtual void take_event(std::vector<JobResult>& results) = 0;
};

struct RealWorkersContext {
  std::shared_ptr<const Body> body;
  StateSolverOptions solving = {};  // spacing, tolerance, displacements
  int count = 1;                    // workers asked for
  Arguments arguments = {};         // the user's settings; empty for built-in kinds
};
struct VirtualWorkersContext {
  ReferenceService& references;  // the values of states: request() early, get() when one is due
  const CostModel& cost;
  int count = 1;             // workers asked for
  bool rest_first = true;    // a job at rest is charged CostModel::rest_seconds()
  double batch_share = 0.5;  // of its cost that a neighbour in a job is charged
  double latency = 0;        // of a message to or from a worker [s]
  Arguments arguments = {};  // the user's settings; empty for built-in kinds
};

struct WorkersKind {
  std::function<std::unique_ptr<RealWorkers>(RealWorkersContext&)> real = {};
  std::function<std::unique_ptr<VirtualWorkers>(VirtualWorkersContext&)> simulated = {};
};

// The workers of a session: a name and the settings behind it. Built in: "threads".
using WorkersSpec = Registered;

// From any thread and also before main() begins. InputError for a name that is taken.
void register_workers(const std::string& name, WorkersKind kind);
std::vector<std::string> workers_names();  // sorted
// InputError lists the names, and says where the kind has no workers for that clock.
std::unique_ptr<RealWorkers> make_real_workers(const WorkersSpec& workers, const RealWorkersContext& context);
std::unique_ptr<VirtualWorkers> make_virtual_workers(const WorkersSpec& workers,
                                                     const VirtualWorkersContext& context);
// InputError as the two above, without making any.
void check_workers(const WorkersSpec& workers, bool virtual_clock);

}  // namespace forefeel
