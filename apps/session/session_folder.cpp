#include "apps/session/session_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <optional>
#include <utility>

#include "apps/console/console.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/result_folder.hpp"
#include "scheduling/record/shape_files.hpp"
#include "scheduling/session/input_replay.hpp"

namespace forefeel {

namespace fs = std::filesystem;

namespace {

void set_aside_states_of_last_run(const Globals& globals, const SessionArguments& given,
                                  const fs::path& run) {
  const fs::path file = run / "session.states";
  std::error_code error;
  if (!fs::exists(file) || (given.states.extend && fs::equivalent(given.states.file, file, error))) return;
  if (!is_database(file))
    throw InputError({.file = file.string()},
                     "is not a state file of an earlier run, expected another folder for the run");
  int k = 1;
  while (fs::exists(run / fmt::format("session-{}.states", k))) ++k;
  warn(globals,
       fmt::format("{}: states of an earlier run, kept as session-{}.states; --states begins with them",
                   file.string(), k));
  for (const char* end : {"-wal", "-shm", ""}) {
    const fs::path part = file.string() + end;
    if (fs::exists(part)) fs::rename(part, run / fmt::format("session-{}.states{}", k, end));
  }
}

}  // namespace

void keep_replayed(const SessionOptions& options, const fs::path& run) {
  std::error_code error;
  if (options.motion.replay && fs::equivalent(*options.motion.replay, run, error))
    throw InputError("-o " + run.string(), "is the run that is replayed, expected another folder");
}

FolderLock::FolderLock(const fs::path& folder)
    : file_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (file_ < 0 || ::flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(file_);
  throw InputError("-o " + folder.string(), "is being written by another session, expected another folder");
}

FolderLock::~FolderLock() {
  if (file_ >= 0) ::close(file_);
}

FolderLock claim_run_folder(const Globals& globals, const SessionArguments& given,
                            std::vector<std::string> shape_files, const fs::path& run) {
  std::optional<FolderLock> lock;
  if (std::error_code error; fs::is_directory(run, error)) lock.emplace(run);
  std::vector<std::string> files{"frames.csv",
                                 "dispatch.csv",
                                 "switches.csv",
                                 "states.csv",
                                 "summary.json",
                                 "report.html",
                                 std::string(inputs_file_name)};
  std::ranges::move(shape_files, std::back_inserter(files));
  const bool again = fs::exists(run / "summary.json");
  claim_folder(run, files);
  if (again)
    say(globals,
        fmt::format("{}: the report, tables and shapes of an earlier run are replaced", run.string()));
  remove_shape_files(run);
  if (!lock) lock.emplace(run);
  set_aside_states_of_last_run(globals, given, run);
  return std::move(*lock);
}

}  // namespace forefeel
