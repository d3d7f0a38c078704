#pragma once
// The files of a run: frames.csv, dispatch.csv, switches.csv and the summary document. Frame logs carry no wall
// time, so that a virtual run is the same byte for byte; real runs append cost_us and lateness_us.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "scheduling/session/session.hpp"

namespace forefeel {

// Makes the folder if need be; InputError unless files can be written there.
void prepare_run_folder(const std::filesystem::path& folder);
void write_run_files(const std::filesystem::path& folder, const SessionResult& result,
                     const SessionOptions& options);
// Every key of the summary but provenance; infinite or unknown values are null.
//   time_in             share of frames by label
//   switch.drift        most that switches changed the force within any 50, 100, 300 ms, |sum of dF| [N]
//   error.parts         95 % quantile of each part over the samples; parts_p50 their medians
//   load                lattice states that the motion's cells need per second, over workers / mean solve time
nlohmann::ordered_json summary_json(const SessionResult& result, const SessionInput& input,
                                    const SessionOptions& options);

}  // namespace forefeel
