#pragma once
// What `forefeel info RUN` says: the run of its summary.json.

#include <filesystem>

#include "apps/console/console.hpp"

namespace forefeel {

int info_run(const Globals& globals, const std::filesystem::path& folder);

}  // namespace forefeel
