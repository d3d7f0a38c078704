#include "scheduling/session/run_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "geometry/common/counted.hpp"
#include "geometry/common/quantiles.hpp"
#include "scheduling/render/input_log.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/workers/cost.hpp"

namespace forefeel {

std::unique_ptr<StateWriter> open_state_file(const std::optional<std::filesystem::path>& file,
                                             const StateFileHeader& header) {
  if (!file) return nullptr;
  return std::make_unique<StateWriter>(StateFile::open_or_create(*file, header));
}

std::unique_ptr<InputLog> open_inputs(const RunRecord& record) {
  if (!record.inputs) return nullptr;
  return std::make_unique<InputLog>(*record.inputs, record.inputs_header, record.inputs_header.real);
}

StateLog::StateLog(const RunRecord& record) : writer_(open_state_file(record.states, record.states_header)) {}

void StateLog::push(const State& state) {
  if (!writer_) return;
  try {
    writer_->push(state);
  } catch (const std::exception& problem) {
    fail(problem);
  }
}

void StateLog::flush() {
  if (!writer_) return;
  try {
    writer_->flush();
  } catch (const std::exception& problem) {
    fail(problem);
  }
}

void StateLog::fail(const std::exception& problem) {
  failure_ = fmt::format("{}; states that were solved later are not in this file", problem.what());
  writer_.reset();
}

std::string failure_in_words(const std::string& what, const std::exception_ptr& failure,
                             const std::string& followed) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::bad_alloc&) {
    return what + " failed: out of memory; " + followed;
  } catch (const std::exception& problem) {
    return fmt::format("{} failed: {}; {}", what, problem.what(), followed);
  } catch (...) {
    return what + " failed; " + followed;
  }
}

Planner::Hooks hooks_of(const RunSetup& setup, StateLog& log, InputLog* inputs) {
  Planner::Hooks hooks;
  hooks.on_state = [&log, inputs](const State& state) {
    log.push(state);
    if (inputs && !state.usable()) inputs->failed(state);
  };
  if (!setup.motion.known.empty())
    hooks.future = [motion = setup.motion.known, frame = setup.motion.clock.frame](double t) {
      const auto k = static_cast<std::size_t>(std::max(0LL, std::llround(t / frame)));
      return motion[std::min(k, motion.size() - 1)];
    };
  if (setup.solving.cost) {  // a body that has been solved before: its median is known
    std::vector<double> seconds = coarse_costs(*setup.solving.cost, setup.planning.space.box);
    if (!seconds.empty()) hooks.expected_solve = median(std::move(seconds));
  }
  return hooks;
}

void take_loop(RenderLoop& loop, std::size_t frames, SessionResult& result) {
  result.frames = loop.take_log();
  if (loop.next() < frames) {
    result.run.end = RunEnd::interrupted;
    result.notes.push_back(
        fmt::format("interrupted after {} of {}", result.frames.size(), counted(frames, "frame")));
  }
  result.loop.ending_frames = loop.safety().counts().ending;
  result.loop.last_force = loop.sent().norm();
  result.loop.device_held = loop.device_faults().held;
  result.loop.device_jumps = loop.device_faults().jumps;
  const SafetyCounts& counts = loop.safety().counts();
  result.safety = {.clamped = counts.clamped,
                   .slewed = counts.slewed,
                   .stale = counts.stale,
                   .non_finite = counts.non_finite,
                   .generated = loop.safety().generated(),
                   .work = loop.safety().work(),
                   .passivity = loop.passivity(),
                   .uncontrolled = loop.take_uncontrolled()};
  if (counts.clamped > 0)
    result.notes.push_back(
        fmt::format("{} of {} clamped by safety: the device got less force than was rendered; the error is "
                    "that of the rendered force",
                    counts.clamped, counted(result.frames.size(), "frame was", "frames were")));
}

}  // namespace forefeel
