#pragma once
// Judges a run, exactly and in the order in which states became known:
//   label of every frame, with the states known in that frame
//   error at sampled frames against a tight solve on the reference branch, e = |F - f| / max(|f|, f0), and its parts
//     approximation |f~ - f|, switch |F - f~|, staleness |f~ - f~*|, each over max(|f|, f0), f~ the newest model,
//     f~* one made from all states known at that moment
// Samples are taken every reference_step of HIP travel, and in the first frame within each lattice cell.
// Where the run hands over its frames as it goes, most is worked out beside it, on a thread of its own; nothing of that
// goes back to the run.

#include <functional>
#include <memory>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/judge/judging_options.hpp"
#include "scheduling/judge/stop_options.hpp"
#include "scheduling/log/session_result.hpp"
#include "scheduling/render/session_model_options.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

struct JudgeSetup {
  StateSpaceOptions space = {};
  ModelRecipe model = {};
  JudgingOptions judging = {};
  StopOptions stop = {};
};

class RunAnalysis {
 public:
  // The references must outlive it. each_position: told where the HIP was in each frame, in order, on its thread.
  RunAnalysis(const JudgeSetup& setup, ReferenceService& references,
              const std::function<void(const Vec3&)>& each_position);
  ~RunAnalysis();

  // The next frame: where the HIP was, and how many states were known. `space`: holds at least these, in their order.
  void frame(const Vec3& at, std::uint32_t known, const StateSpace& space);
  // On its thread, for each frame in order: its number, where the HIP was and what was known, which space() then holds.
  using EachFrame = std::function<void(std::size_t k, const Vec3& at, std::uint32_t known)>;
  void begin(EachFrame each);              // before the first frame
  const StateSpace& space() const;         // for EachFrame alone
  void catch_up(const StateSpace& space);  // returns when all frames so far are done
  // After the run: what was not handed over, then all that result.frames and .switches lack.
  void finish(SessionResult& result, const ShowProgress& show);

 private:
  std::vector<std::size_t> enter_labels(SessionResult& result) const;
  void enter_errors(const std::vector<std::size_t>& samples, SessionResult& result, const ShowProgress& show);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
