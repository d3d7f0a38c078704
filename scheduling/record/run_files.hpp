#pragma once
// The tables of a run: frames.csv, dispatch.csv and switches.csv. They hold no wall time under the virtual
// clock, so that a virtual run gives the same bytes each time; real runs append cost_us and lateness_us.

#include <filesystem>

#include "scheduling/session/session.hpp"

namespace forefeel {

// Makes the folder where it is missing; InputError unless files can be written there.
void prepare_run_folder(const std::filesystem::path& folder);
void write_run_files(const std::filesystem::path& folder, const SessionResult& result,
                     const SessionOptions& options);

}  // namespace forefeel
