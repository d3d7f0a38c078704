#pragma once
// What run_session is put together from; not for users.

#include <functional>
#include <memory>
#include <vector>

#include "scheduling/cost.hpp"
#include "scheduling/planner.hpp"
#include "scheduling/reference_service.hpp"
#include "scheduling/session.hpp"

namespace forefeel {

using ShowProgress = std::function<void(const SessionProgress&)>;

// A state that becomes known at a given time.
struct Arrival {
  double t = 0;          // [s]
  Vec3 at = Vec3::Zero();
};

// All that is fixed before the first frame.
struct SessionPlan {
  SessionPlan(const SessionInput& given, const SessionOptions& chosen) : input(given), options(chosen) {}

  const SessionInput& input;
  SessionOptions options;               // the force limit that of the device where that is lower
  std::size_t frames = 0;
  std::unique_ptr<Device> device;
  std::vector<Vec3> motion;             // by frame, for a policy that knows it; else empty
  std::vector<Arrival> arrivals;        // by growing time
  bool given_arrivals = false;          // nothing is dispatched then
  std::unique_ptr<CostModel> cost;      // virtual clock
};

std::vector<Arrival> read_arrivals(const std::filesystem::path& file);   // t,x,y,z; sorted by time
struct Replay {
  Trace motion;
  std::vector<Arrival> arrivals;
};
Replay read_replay(const std::filesystem::path& run_folder);

void run_virtual(SessionPlan& plan, ReferenceService& references, SessionResult& result, const ShowProgress& show);
void run_real(SessionPlan& plan, ReferenceService& references, SessionResult& result, const ShowProgress& show);

// After the run: exact label of every frame, first visits, and at sampled frames the error and its parts.
void analyse(const SessionInput& input, const SessionOptions& options, ReferenceService& references,
             SessionResult& result, const ShowProgress& show);

Planner::Hooks hooks_of(const SessionPlan& plan, StateWriter* writer);
void take_loop(RenderLoop& loop, std::size_t frames, SessionResult& result);   // its log and counters

}  // namespace forefeel
