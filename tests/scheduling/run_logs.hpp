#pragma once
// The files of a run as bytes.

#include "scheduling/record/run_files.hpp"
#include "scheduling/session/session.hpp"
#include "tests/support/test.hpp"

namespace forefeel::test {

// The three logs of a run, as bytes.
inline std::string logs(const SessionInput& input, const SessionOptions& options, const fs::path& folder) {
  prepare_run_folder(folder);
  write_run_files(folder, run_session(input, options), options);
  return text_of(folder / "frames.csv") + text_of(folder / "dispatch.csv") + text_of(folder / "switches.csv");
}

}  // namespace forefeel::test
