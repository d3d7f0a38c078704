#pragma once
// The folder of a run of `forefeel session`: what may be written into it, and what an earlier run left there.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "apps/session/session_arguments.hpp"

namespace forefeel {

// InputError for the folder of the run that is replayed, which must not be overwritten.
void keep_replayed(const SessionOptions& options, const std::filesystem::path& run);

// A folder is one session's as long as its lock lives, and no longer than the process. It leaves no file behind.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;

 private:
  int file_;
};

// Makes the folder, or removes an earlier run's files from it. InputError if another session writes into it, or if a
// file that forefeel has not written has one of the names that the session writes; then nothing is changed.
// shape_files: names that it writes for shapes. States of an earlier run, unless they are extended, are renamed to
// session-1.states, session-2.states, … and kept.
[[nodiscard]] FolderLock claim_run_folder(const Globals& globals, const SessionArguments& given,
                                          std::vector<std::string> shape_files,
                                          const std::filesystem::path& run);

}  // namespace forefeel
