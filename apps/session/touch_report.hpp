#pragma once
// The report of a session with contact.anywhere: one HTML file.

#include <filesystem>

#include "apps/scene/scene.hpp"
#include "apps/session/touch_summary.hpp"

namespace forefeel {

// document: summary.json, printed in full at the end of the page. InputError if the file cannot be written.
void write_touch_report(const std::filesystem::path& run, const TouchSessionResult& result,
                        const TouchSessionInput& input, const SessionOptions& options,
                        const TouchSummary& summary, const Json& document, const Scene& scene);

}  // namespace forefeel
