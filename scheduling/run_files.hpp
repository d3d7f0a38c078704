#pragma once
// The files of a run: frames.csv, dispatch.csv, switches.csv and the summary document. Frame logs carry no wall
// time, so that a virtual run is the same byte for byte; real runs append cost_us and lateness_us.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "scheduling/session.hpp"

namespace forefeel {

void write_run_files(const std::filesystem::path& folder, const SessionResult& result, const SessionOptions& options);
// Every key of the summary but provenance; infinite or unknown values are null.
nlohmann::ordered_json summary_json(const SessionResult& result, const SessionInput& input, const SessionOptions& options);

}  // namespace forefeel
