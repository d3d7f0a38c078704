#pragma once
// The report of a run: one HTML file that needs no other file and no network.

#include <filesystem>
#include <future>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/scene/scene.hpp"
#include "apps/session/report_figures.hpp"
#include "apps/session/run_view.hpp"
#include "scheduling/record/summary.hpp"
#include "solver/jet/rest_sites.hpp"

namespace forefeel {

using Picture = std::shared_future<std::string>;  // HTML

// Each picture is made on its own thread. All but the slices read the session's result, so the result must outlive
// them. Slices, still (curves for browsers without scripts) and deadlines are drawn by gnuplot; they are empty without
// it.
struct ReportPictures {
  Picture slices, still, deadlines;  // deadlines: only with a real clock
  Picture charts, moments;           // curves that can be zoomed; the worst moments
  Picture shape = {};                // of the body over time; invalid where no shapes were wanted
  Picture sites = {};                // where a body was touched; invalid for one place of contact
};
Picture begin_sites(const SessionResult& result, const RestSites& rest);
// Begins to draw slices that show the coverage in the course of a session. Copies what it needs from the result.
Picture begin_slices(const SessionResult& result, const StateSpaceOptions& space);
ReportPictures begin_pictures(const SessionResult& result, Picture slices, const RunView& view);
// The same pictures as scripts, for files: force, labels and errors over time; slices; deadlines of a real clock.
std::vector<Figure> run_figures(const SessionResult& result, const StateSpaceOptions& space,
                                const RunView& view);
// force_limit: largest force that is sent [N].
RunView view_of(const StateSpaceOptions& space, const SessionOptions& options, double force_limit);

// Writes run_folder/report.html. document: summary.json, printed in full at the end of the page. Without
// gnuplot the report has no plots, and a note says why. Throws InputError if the file cannot be written.
void write_report(const std::filesystem::path& run_folder, const SessionSummary& summary,
                  const nlohmann::ordered_json& document, const Scene& scene, const ReportPictures& pictures);

}  // namespace forefeel
