#pragma once
// One writer at a time: the lock of a state file that is open for appending.
// It is a file of its own beside the database (NAME-lock), because closing any descriptor of the database
// would drop SQLite's own locks. The operating system releases the lock when the process ends, however it
// ends.

#include <filesystem>
#include <string>

namespace forefeel {

class WriterLock {
 public:
  // InputError that names the file if another process holds the lock or if it cannot be made.
  explicit WriterLock(const std::filesystem::path& file);
  ~WriterLock();
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

 private:
  std::string read_owner() const;  // " (PID)" of the process that holds it, or nothing

  std::string path_;
  int descriptor_ = -1;
};

}  // namespace forefeel
