#pragma once
// A file that appears complete or not at all. It is written under a temporary name in the same folder;
// commit() syncs it to the disk and renames it. Without commit() nothing is left behind. Devices and
// open pipes (/dev/stdout) are written directly; a named pipe is refused. Symbolic links are followed; permissions are
// kept.

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

namespace forefeel {

class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path file);  // InputError where it cannot be written
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view bytes);  // buffered; InputError on a full disk, here or in commit()
  void commit();                       // durable and visible on return

 private:
  [[noreturn]] void fail(int error);
  void flush();
  void discard();

  std::filesystem::path file_, temporary_;  // temporary_ empty: written directly
  std::string buffer_;
  int descriptor_ = -1;
};

// Writes all of a file.
void write_whole(const std::filesystem::path& file, std::string_view bytes);

// True for a database of SQLite, such as a state file.
bool is_database(const std::filesystem::path& file);

// InputError if a file of that name could not be made (no such folder, not writable), or if it is one of the
// input files in `read`. Makes nothing.
void check_appendable(const std::filesystem::path& file,
                      std::initializer_list<std::filesystem::path> read = {});

// The same for a file that is written anew: a database is never replaced, because states took long to solve.
void check_writable(const std::filesystem::path& file,
                    std::initializer_list<std::filesystem::path> read = {});

}  // namespace forefeel
