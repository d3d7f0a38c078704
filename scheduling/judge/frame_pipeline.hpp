#pragma once
// What follows a run, beside it: the run passes on each frame, and one thread takes the frames in their order
// through stages.
//   run  --(HIP, number of known states; the states)-->  pipeline  -->  stage 1  -->  stage 2 …
// known() holds in each frame exactly the states that the run knew in it. Nothing goes back to the run.
//
//   FramePipeline pipeline(space_options);
//   pipeline.add(renderer);                     // stages see a frame in this order
//   pipeline.add(judge);
//   pipeline.pass(hip, space.size(), space);    // by the run, frame after frame
//   pipeline.wait();

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/log/session_result.hpp"

namespace forefeel {

struct PassedFrame {
  std::size_t k = 0;        // its number, from 0
  Vec3 at = Vec3::Zero();   // of the HIP [m]
  std::uint32_t known = 0;  // number of known states
  bool grown = false;       // more than in the frame before
};

class FrameStage {
 public:
  virtual ~FrameStage() = default;
  virtual void frame(const PassedFrame& frame) = 0;  // on the pipeline's thread, for each frame in order
};

class FramePipeline {
 public:
  explicit FramePipeline(const StateSpaceOptions& space);
  ~FramePipeline();  // drops what is not worked off
  FramePipeline(const FramePipeline&) = delete;
  FramePipeline& operator=(const FramePipeline&) = delete;

  void add(std::shared_ptr<FrameStage> stage);  // before the first frame
  // Of the pipeline's thread; stages may keep the reference.
  const StateSpace& known() const;

  // The run's next frame. `space` holds at least the known states, in the order in which they became known.
  void pass(const Vec3& at, std::uint32_t known, const StateSpace& space);
  // The frames that were not passed on while the run went; `states` as in pass().
  void pass_rest(std::span<const FrameRecord> frames, std::span<const State> states);
  void hand_over(
      const StateSpace& space);  // frames are handed to the thread in lots: hands over the last lot
  // Returns once all frames that were handed over are through; throws what a stage threw.
  void wait(const ShowProgress& show = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
