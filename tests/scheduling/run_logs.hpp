#pragma once
// The files of a run as bytes.

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "scheduling/record/run_files.hpp"
#include "scheduling/session/session.hpp"

namespace forefeel::testing {

inline std::string text(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::stringstream all;
  all << in.rdbuf();
  return all.str();
}

// The three logs of a run, as bytes.
inline std::string logs(const SessionInput& input, const SessionOptions& options,
                        const std::filesystem::path& folder) {
  prepare_run_folder(folder);
  write_run_files(folder, run_session(input, options), options);
  return text(folder / "frames.csv") + text(folder / "dispatch.csv") + text(folder / "switches.csv");
}

}  // namespace forefeel::testing
