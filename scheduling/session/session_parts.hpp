#pragma once
// What run_session is put together from; not for users.

#include <functional>
#include <memory>
#include <vector>

#include "scheduling/plan/planner.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

using ShowProgress = std::function<void(const SessionProgress&)>;

// A state that becomes known at a given time.
struct Arrival {
  double t = 0;  // [s]
  Vec3 at = Vec3::Zero();
};

// All that is fixed before the first frame.
struct SessionPlan {
  SessionPlan(const SessionInput& given, const SessionOptions& chosen) : input(given), options(chosen) {}

  const SessionInput& input;
  SessionOptions options;  // the force limit that of the device where that is lower
  std::size_t frames = 0;
  std::unique_ptr<Device> device;
  std::vector<Vec3> motion;         // by frame, for a policy that knows it; else empty
  std::vector<Arrival> arrivals;    // by growing time
  bool given_arrivals = false;      // nothing is dispatched then
  std::unique_ptr<CostModel> cost;  // virtual clock
};

// t,x,y,z; sorted by time. InputError names file and line of one that is farther than so from rest [m].
std::vector<Arrival> read_arrivals(const std::filesystem::path& file, double farthest);
struct Replay {
  Trace motion;
  std::vector<Arrival> arrivals;
  bool of_arrivals = false;  // nothing was solved in that run
};
Replay read_replay(const std::filesystem::path& run_folder, double farthest);

class RunAnalysis;

void run_virtual(SessionPlan& plan, ReferenceService& references, RunAnalysis& analysis,
                 SessionResult& result, const ShowProgress& show);
void run_real(SessionPlan& plan, ReferenceService& references, SessionResult& result,
              const ShowProgress& show);

// Exact label of every frame, first visits, and at sampled frames the error and its parts. Where the run hands over what
// is done so far, most of it is worked out beside the run, on a thread of its own; nothing of that goes back to the run.
class RunAnalysis {
 public:
  // All must outlive it. each_position: see run_session().
  RunAnalysis(const SessionInput& input, const SessionOptions& options, ReferenceService& references,
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
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

Planner::Hooks hooks_of(const SessionPlan& plan, StateWriter* writer);
void take_loop(RenderLoop& loop, std::size_t frames, SessionResult& result);  // its log and counters

}  // namespace forefeel
