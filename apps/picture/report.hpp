#pragma once
// The report of a run: one self-contained HTML file (inline SVG by gnuplot, nothing loaded from outside).

#include <filesystem>
#include <future>
#include <string>

#include "apps/console/command.hpp"
#include "apps/scene_input/scene.hpp"
#include "scheduling/session/session.hpp"

namespace forefeel {

using Picture = std::shared_future<std::string>;  // HTML; empty without gnuplot

// Drawn on threads of their own. Time, start and deadlines read the frames until they are drawn: the result must outlive
// them.
struct ReportPictures {
  Picture slices, time, start, deadlines;  // deadlines: only with a real clock
};
// What was known where, from a session that has run; what it needs of the result is copied.
Picture begin_slices(const SessionResult& result, const StateSpaceOptions& space);
ReportPictures begin_pictures(const SessionResult& result, Picture slices);

// Writes run_folder/report.html. summary: that of the run, which may hold "notes": ["…"], shown as they are. Without
// gnuplot the report is written without plots and says so. Throws InputError where the file cannot be written.
void write_report(const std::filesystem::path& run_folder, const nlohmann::ordered_json& summary,
                  const Scene& scene, const ReportPictures& pictures);

}  // namespace forefeel
