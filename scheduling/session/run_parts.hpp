#pragma once
// Functions shared by the runs of both clocks.

#include <cstddef>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/states/state_file.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/planner.hpp"
#include "scheduling/session/session_setup.hpp"

namespace forefeel {

class InputLog;

// The file that new states are appended to; null: none. InputError if it cannot be opened.
std::unique_ptr<StateWriter> open_state_file(const std::optional<std::filesystem::path>& file,
                                             const StateFileHeader& header);

// The log of the run's inputs (render/input_log.hpp); null: none is wanted. InputError if it cannot be written.
std::unique_ptr<InputLog> open_inputs(const RunRecord& record);

// The state file during a run. If the disk fails, the run continues without it, and failure() returns the error.
class StateLog {
 public:
  explicit StateLog(const RunRecord& record);  // InputError where the file cannot be opened
  void push(const State& state);               // one thread
  void flush();                                // returns when all is on the disk, or the disk has failed
  const std::optional<std::string>& failure() const { return failure_; }  // one line

 private:
  void fail(const std::exception& problem);

  std::unique_ptr<StateWriter> writer_;
  std::optional<std::string> failure_;
};

// The planner's hooks. inputs: null where nothing is recorded. The setup and both logs must outlive the hooks.
Planner::Hooks hooks_of(const RunSetup& setup, StateLog& log, InputLog* inputs);
// Moves the log and the safety counters of a run into its result. `frames`: the number requested.
void take_loop(RenderLoop& loop, std::size_t frames, SessionResult& result);
// One line for an exception: what failed, why, and what followed.
std::string failure_in_words(const std::string& what, const std::exception_ptr& failure,
                             const std::string& followed = "the session ended early");

}  // namespace forefeel
