#pragma once
// What a session prints when it ends: what ran, four figures with their meaning, and where its report is.

#include <filesystem>
#include <optional>
#include <string>

#include "apps/console/console.hpp"
#include "scheduling/record/summary.hpp"

namespace forefeel {

// shapes: the line about the body's shapes, if there are any; run: the folder of the files.
void tell_session(const Globals& globals, const SessionSummary& summary,
                  const std::optional<std::string>& shapes, const std::filesystem::path& run);

}  // namespace forefeel
