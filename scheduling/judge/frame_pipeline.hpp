#pragma once
// Processes the frames of a run during the run. The run passes on each frame; one thread takes the frames
// in order through all stages.
//   run  --(HIP, number of known states; the states)-->  pipeline  -->  stage 1  -->  stage 2 …
// During each frame, known() holds exactly the states that the run knew in that frame. Nothing flows back to
// the run.
//
//   FramePipeline pipeline(space_options);
//   pipeline.add(renderer);                     // each frame visits the stages in this order
//   pipeline.add(judge);
//   pipeline.pass(hip, space.size(), space);    // by the run, frame after frame
//   pipeline.wait();

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/common/session_result.hpp"

namespace forefeel {

struct PassedFrame {
  std::size_t k = 0;        // its number, from 0
  Vec3 at = Vec3::Zero();   // of the HIP [m]
  std::uint32_t known = 0;  // number of known states
  bool grown = false;       // more states than in the frame before
  bool ending = false;      // the session is ended early: the force goes to zero
};

class FrameStage {
 public:
  virtual ~FrameStage() = default;
  virtual void frame(const PassedFrame& frame) = 0;  // on the pipeline's thread, for each frame in order
};

class FramePipeline {
 public:
  explicit FramePipeline(const StateSpaceOptions& space);
  ~FramePipeline();  // drops frames not yet processed
  FramePipeline(const FramePipeline&) = delete;
  FramePipeline& operator=(const FramePipeline&) = delete;

  void add(std::shared_ptr<FrameStage> stage);  // before the first frame
  // To be read on the pipeline's thread; stages may keep the reference.
  const StateSpace& known() const;

  // Passes on the run's next frame. `space` holds at least the first `known` states, in the order in which
  // they became known.
  void pass(const Vec3& at, std::uint32_t known, const StateSpace& space, bool ending = false);
  // Passes on the frames not passed on during the run; `states` in the order of pass().
  void pass_rest(std::span<const FrameRecord> frames, std::span<const State> states);
  void flush(const StateSpace& space);  // frames go to the thread in batches: sends the last, incomplete one
  // Returns when all frames have been processed. Rethrows an exception of a stage.
  void wait(const ShowProgress& show = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
