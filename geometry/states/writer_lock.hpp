#pragma once
// The lock of a state file that is open for appending: one writer at a time, under whichever name the file is opened.
//   NAME-lock   a separate lock file beside the database, NAME with its symbolic links followed. It also protects
//               the database while it is being created.
//   the file    the database itself (device and inode), locked by flock(2), for mounts that show one file in two
//               places. Not used on network file systems, which turn flock into the kind of lock that SQLite uses.
//   hard links  SQLite keeps the newest states in NAME-wal, which belongs to one name. A file with several names
//               is therefore never written.
// The operating system releases the locks when the process ends, however it ends.

#include <filesystem>
#include <string>

namespace forefeel {

class WriterLock {
 public:
  // file: with its symbolic links followed; it may be missing. InputError that names the file if another
  // process holds the lock, if it cannot be made, or if the file has several names.
  explicit WriterLock(const std::filesystem::path& file);
  ~WriterLock();
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

  void take_file();  // also locks the file itself, which must exist now; the same errors

 private:
  void lock_name();
  std::string read_owner() const;  // " (PID)" of the process that holds it, or nothing

  std::string file_, path_;            // path_: of the lock
  int descriptor_ = -1, target_ = -1;  // target_: of the file itself; closed after the database is
};

// The number of names (hard links) of a file; 0 if it is missing.
std::size_t names_of(const std::filesystem::path& file);
// True if a process that writes the file holds its lock, under whichever name.
bool is_being_written(const std::filesystem::path& file);

}  // namespace forefeel
