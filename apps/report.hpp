#pragma once
// The report of a run: one self-contained HTML file (inline SVG by gnuplot, nothing loaded from outside).

#include <filesystem>
#include <future>
#include <string>

#include "apps/command.hpp"
#include "apps/scene.hpp"
#include "scheduling/session.hpp"

namespace forefeel {

// Writes run_folder/report.html from summary.json, frames.csv, dispatch.csv and switches.csv there (all must exist;
// summary.json may hold "notes": ["…"], shown as they are). States in the pictures: the solved and arrived rows of
// dispatch.csv, and those of the start from the head of states.csv. Without gnuplot the report is written without
// plots and says so. Throws InputError for a folder that is no run or cannot be written.
// slice: the pictures of what was known where, if begin_slices() drew them already.
using Picture = std::shared_future<std::string>;   // HTML
void write_report(const std::filesystem::path& run_folder, const Scene& scene, const Globals& globals, const Picture& slice = {});

// Draws them on a thread of its own from a session that has run; what it needs of the result is copied.
Picture begin_slices(const SessionResult& result, const StateSpaceOptions& space);

}  // namespace forefeel
