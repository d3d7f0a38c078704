#pragma once
// Renders a recorded run again, without a clock, a device or a worker, and compares every force with the recorded one,
// bit by bit. States are added in the recorded order, each model is made by the same calls from the same states, and
// each frame gets its recorded position, newest model and two times. The code of the session itself renders:
// SessionModel and RenderLoop.
//
// The forces are equal if the same program runs on the same instruction set; another one may round differently.
// Error bars and labels are not replayed: no force depends on them.
//
// Of a body that may be touched anywhere the record does not hold the field. The caller gives it; settings_in_words()
// must be that of the record.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/common/types.hpp"

namespace forefeel {

inline constexpr std::string_view inputs_file_name = "session.inputs";  // in the folder of a run

struct ForceDifference {
  std::size_t frame = 0;  // its number
  double t = 0;           // [s]
  bool sent = false;      // of the force sent; false: already of the rendered one
  Vec3 recorded = Vec3::Zero(), replayed = Vec3::Zero();  // [N]
};

struct ReplayReport {
  std::size_t frames = 0, equal = 0;  // equal: rendered and sent force have the recorded bits
  std::size_t states = 0, failed = 0, models = 0;
  double seconds = 0;       // time of the last frame [s]
  std::uint64_t bytes = 0;  // of the file, as far as it was read
  bool whole = false;  // false: the run was killed or its disk was full; the existing records were replayed
  std::string made_by, replayed_by;
  std::optional<ForceDifference> first = {};  // none: all are equal
};

struct TouchedBody;
struct TouchTask;

// What the forces of a body that may be touched anywhere depend on, beside its states; a line each.
std::string settings_in_words(const TouchedBody& touched);

// file: RUN/session.inputs. program: as in SessionFiles. progress: called with the time reached [s]. touched: called
// for a record of a body that may be touched anywhere; empty: there is none.
// InputError: no such file, it is damaged, or another body is touched.
ReplayReport replay_inputs(const std::filesystem::path& file, const std::string& program = {},
                           const std::function<void(double)>& progress = {},
                           const std::function<TouchedBody()>& touched = {});

}  // namespace forefeel
