#pragma once
// Who solves states: the planner hands jobs to idle workers and may cancel them; results come back to the planner's
// receive(). Implemented by threads (real clock) and by simulated workers (virtual clock).

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <vector>

#include "solver/equilibrium/solver.hpp"

namespace forefeel {

struct Job {
  struct Neighbour {
    std::uint32_t dispatch = 0;
    Vec3 at = Vec3::Zero();  // [m]
  };
  std::uint32_t dispatch = 0;  // row of dispatch.csv
  Vec3 at = Vec3::Zero();      // [m]
  std::shared_ptr<const Equilibrium>
      start;  // nearest known solution, or where a solve of this one was broken off; null: rest
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
  virtual int workers() const = 0;  // ready to take jobs; may grow
  virtual void dispatch(int worker,
                        Job job) = 0;   // the worker is idle; a result comes for each state of the job
  virtual void cancel(int worker) = 0;  // results still come: cancelled, or solved if it was too late
};

// Workers of the real clock.
class RealWorkers : public Generator {
 public:
  // Results since the last call; waits up to `timeout` seconds for one.
  virtual void collect(std::vector<JobResult>& out, double timeout) = 0;
  virtual void stop() = 0;  // running solves are cancelled; collect() once more for what is left
  virtual std::exception_ptr failure() const = 0;  // of a worker, if any
};

}  // namespace forefeel
