#pragma once
// Recordings as a factor of a study: a device "trace:traces/*.csv,unit=mm" stands for one device for each file that the
// pattern matches, sorted by name. Half of the files may be kept for tuning, so that no recording is used for both.

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "apps/study/study_toml.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {

// tuning: the first file of a pattern, the third, the fifth …; table: the others.
enum class TraceHalf : std::uint8_t { all, tuning, table };
// Of the key `traces`: all if the study has none. InputError for another word.
TraceHalf study_traces(const toml::node* node, const InputPlace& place);

// Whether a value of the devices is a pattern: trace:, and * or ? in its file.
bool is_trace_pattern(const toml::node& node);

// The devices of a pattern: what the tables say (the file's stem, then the settings), and the device's text. The
// pattern is relative to the study's folder, else to the scene's. InputError at `place` where no file is left.
std::vector<std::pair<std::string, std::string>> matching_traces(const std::string& pattern, TraceHalf half,
                                                                 const std::filesystem::path& study,
                                                                 const std::filesystem::path& scene,
                                                                 const InputPlace& place);

}  // namespace forefeel
