#pragma once
// Makes shapes under the real clock, in a separate thread:
//   planner  --(newest HIP: triple buffer; new states: a list under a mutex)-->  shape thread  -->  ShapeLog
// The 1 kHz loop does nothing for the shapes: the planner receives the HIP from the loop anyway, and passes it on.
// The thread has no real-time priority. At each instant k / rate it takes the newest HIP. Instants that it misses are
// counted. It never waits for a disk: the files are written from the records after the run.

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/judge/frame_pipeline.hpp"
#include "scheduling/motion/hip_sample.hpp"
#include "scheduling/render/triple_buffer.hpp"
#include "scheduling/shape/shape_log.hpp"

namespace forefeel {

class ShapeThread {
 public:
  // now(): session time [s], of the steady clock, from any thread. The log must outlive the thread, which alone
  // uses it until end().
  ShapeThread(ShapeLog& log, std::function<double()> now);
  ~ShapeThread() { end(); }
  ShapeThread(const ShapeThread&) = delete;
  ShapeThread& operator=(const ShapeThread&) = delete;

  // By one thread, the owner of the space. Takes the mutex only when states have come.
  void pass(const HipSample& hip, const StateSpace& space);
  void end();  // returns when the thread has ended
  // After end(): one line if it failed; it made no shapes after that.
  const std::optional<std::string>& failure() const { return failure_; }

 private:
  void work(const std::stop_token& stop);
  void take_states();

  ShapeLog& log_;
  std::function<double()> now_;
  TripleBuffer<HipSample> hip_;
  std::size_t passed_ = 0;  // states, by the passing thread
  std::mutex mutex_;
  std::condition_variable_any ending_;
  std::vector<State> fresh_, taken_;  // under the mutex; the thread's own
  std::optional<std::string> failure_;
  std::jthread thread_;  // the last member: it ends first
};

// Makes shapes under the virtual clock: a stage of the frame pipeline (judge/frame_pipeline.hpp) that takes a shape at
// the first frame at or after each instant k / rate. Repeated runs give the same bytes.

class ShapeStage final : public FrameStage {
 public:
  // known: FramePipeline::known(); frame: time of a frame [s]. Log and space must outlive the stage.
  ShapeStage(ShapeLog& log, const StateSpace& known, double frame);
  void frame(const PassedFrame& frame) override;
  // One line if it failed; it makes no shapes after that.
  const std::optional<std::string>& failure() const { return failure_; }

 private:
  void follow(const PassedFrame& frame);

  ShapeLog& log_;
  const StateSpace& known_;
  double frame_;
  std::size_t taken_ = 0;
  std::optional<std::string> failure_;
};

// Shapes of a body that is touched anywhere, of a run that has ended: at its first frame at or after each instant
// k / rate, of the states known then. known: in the order in which they became known. Returns one line if it fails;
// there are no shapes after that.
std::optional<std::string> take_shapes(ShapeLog& log, std::span<const FrameRecord> frames,
                                       std::span<const State> known);

}  // namespace forefeel
