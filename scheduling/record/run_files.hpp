#pragma once
// The tables of a run: frames.csv, dispatch.csv and switches.csv. In frames.csv fx, fy, fz is the force sent
// to the device, rendered_x … the force before the safety rules, ux … that of the newest model, rx … the
// reference (summary.hpp defines these words; `error` is that of the rendered force). A virtual run gives the
// same bytes each time: its tables hold no wall time. Real runs append cost_us and lateness_us.

#include <filesystem>
#include <span>
#include <vector>

#include "geometry/common/declared.hpp"
#include "scheduling/session/session.hpp"

namespace forefeel {

// Makes the folder if it is missing. Throws InputError if files cannot be written there.
void prepare_run_folder(const std::filesystem::path& folder);
// Writes every table that can be written, then throws one InputError that names those that cannot.
void write_run_files(const std::filesystem::path& folder, const SessionResult& result,
                     const SessionOptions& options);

// The columns of the three tables, with unit and meaning: those that write_run_files() writes.
std::vector<DeclaredTable> declared_run_files();

// The columns themselves (field.hpp), for arrays with the same cells.
template <class Record>
struct Field;
std::span<const Field<FrameRecord>> frame_columns();
std::span<const Field<DispatchRecord>> dispatch_columns();
std::span<const Field<SwitchRecord>> switch_columns();

}  // namespace forefeel
