#pragma once
// The report of a run: one HTML file that needs no other file (inline SVG by gnuplot).

#include <filesystem>
#include <future>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "apps/scene_input/scene.hpp"
#include "scheduling/record/summary.hpp"

namespace forefeel {

using Picture = std::shared_future<std::string>;  // HTML; empty without gnuplot

// Each picture is drawn on its own thread. time, start and deadlines read the frames of the result meanwhile,
// so the result must outlive them.
struct ReportPictures {
  Picture slices, time, start, deadlines;  // deadlines: only with a real clock
};
// Draws what was known where, after a session. Copies what it needs from the result.
Picture begin_slices(const SessionResult& result, const StateSpaceOptions& space);
// force_limit: what is sent is cut at [N].
ReportPictures begin_pictures(const SessionResult& result, Picture slices, double force_limit);

// Writes run_folder/report.html. document: summary.json, printed in full at the end of the page. Without
// gnuplot the report has no plots and says so. Throws InputError if the file cannot be written.
void write_report(const std::filesystem::path& run_folder, const SessionSummary& summary,
                  const nlohmann::ordered_json& document, const Scene& scene, const ReportPictures& pictures);

}  // namespace forefeel
