#include "geometry/common/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>
#include <array>
#include <fstream>
#include <string_view>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/link_target.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

// True for a pipe or socket that this process has already open, such as /dev/stdout or /dev/fd/63.
bool is_open_here(const struct stat& wanted) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/proc/self/fd", error)) {
    struct stat status {};
    if (::stat(entry.path().c_str(), &status) == 0 && status.st_dev == wanted.st_dev &&
        status.st_ino == wanted.st_ino)
      return true;
  }
  return false;
}

// True for a device or an open pipe. InputError for a named pipe: opening it would wait for a reader.
bool is_special(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0 || S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)) return false;
  if (S_ISCHR(status.st_mode) || is_open_here(status)) return true;
  throw InputError({.file = file.string()},
                   S_ISBLK(status.st_mode)
                       ? "is a disk, expected a file to write"
                       : "is a named pipe or socket, expected a file to write, or /dev/stdout");
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

// Removes files .NAME.PID-N.part whose process PID has ended without doing so.
void sweep_parts(const fs::path& folder, const std::string& name) {
  std::error_code error;
  const std::string prefix = "." + name + ".";
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string found = entry.path().filename().string();
    if (!found.starts_with(prefix) || !found.ends_with(".part")) continue;
    int process = 0;
    const char* const begin = found.data() + prefix.size();
    const auto [end, bad] = std::from_chars(begin, found.data() + found.size(), process);
    if (bad != std::errc{} || *end != '-' || process <= 0) continue;
    if (::kill(process, 0) != 0 && errno == ESRCH) fs::remove(entry.path(), error);
  }
}

// Opens the temporary file. It gets the mode of the file that it replaces before anything is written.
int open_part(const fs::path& part, const fs::path& replaced) {
  struct stat status {};
  const bool replaces = ::stat(replaced.c_str(), &status) == 0;
  const int descriptor =
      ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, replaces ? 0600 : 0666);
  if (descriptor < 0 || !replaces) return descriptor;
  if (::fchown(descriptor, status.st_uid, status.st_gid) != 0) {
    // Only root may change the owner of a file. If this fails, the file belongs to the writing user.
  }
  ::fchmod(descriptor, status.st_mode & 07777);
  return descriptor;
}

}  // namespace

fs::path followed(const fs::path& file) {
  std::error_code error;
  if (!fs::is_symlink(file, error)) return file;
  fs::path at = file;
  for (int links = 0; fs::is_symlink(at, error); ++links) {
    if (links == 40)
      throw InputError({.file = file.string()}, "is a symbolic link in a circle, expected a file");
    at = folder_of(at) / fs::read_symlink(at);  // an absolute target replaces the folder
  }
  return at;
}

void write_whole(const std::filesystem::path& file, std::string_view bytes) {
  OutputFile out(file);
  out.write(bytes);
  out.commit();
}

bool is_database(const fs::path& file) {
  constexpr std::string_view magic("SQLite format 3\0", 16);
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return false;
  std::array<char, magic.size()> start{};
  std::ifstream(file, std::ios::binary).read(start.data(), start.size());
  return std::string_view(start.data(), start.size()) == magic;
}

void check_appendable(const fs::path& file, std::initializer_list<fs::path> read) {
  std::error_code error;
  if (file.empty()) throw InputError("output file", "has no name, expected a path");
  if (is_special(file)) return;
  if (fs::is_directory(file, error))
    throw InputError({.file = file.string()}, "is a folder, expected a file to write");
  const fs::path folder = folder_of(followed(file));
  if (!fs::is_directory(folder, error))
    throw InputError({.file = file.string()},
                     fmt::format("cannot be written, folder {} does not exist", folder.string()));
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw InputError({.file = file.string()}, fmt::format("cannot be written: {}", std::strerror(errno)));
  if (fs::exists(file, error) && ::access(file.c_str(), W_OK) != 0)
    throw InputError({.file = file.string()}, fmt::format("cannot be written: {}", std::strerror(errno)));
  for (const fs::path& input : read)
    if (!input.empty() && fs::equivalent(file, input, error))
      throw InputError({.file = file.string()},
                       fmt::format("would replace {}, which is read, expected another file", input.string()));
}

void check_writable(const fs::path& file, std::initializer_list<fs::path> read) {
  check_appendable(file, read);
  if (is_database(file))
    throw InputError({.file = file.string()}, "is a state file, expected the name of another file to write");
}

OutputFile::OutputFile(fs::path file) : file_(std::move(file)) {
  check_writable(file_);
  if (is_special(file_)) {  // not followed: the link /dev/stdout of a pipe leads to no name
    descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    file_ = followed(file_);
    static std::atomic<unsigned> counter{0};
    sweep_parts(folder_of(file_), file_.filename().string());
    temporary_ =
        folder_of(file_) / fmt::format(".{}.{}-{}.part", file_.filename().string(), ::getpid(), counter++);
    descriptor_ = open_part(temporary_, file_);
  }
  if (descriptor_ < 0) fail(errno);
}

OutputFile::~OutputFile() {
  discard();
}

void OutputFile::discard() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  descriptor_ = -1;
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void OutputFile::fail(int error) {
  discard();
  throw InputError({.file = file_.string()}, fmt::format("cannot be written: {}", std::strerror(error)));
}

void OutputFile::write(std::string_view bytes) {
  buffer_.append(bytes);
  if (buffer_.size() >= (1u << 16)) flush();
}

void OutputFile::flush() {
  std::string_view left = buffer_;
  while (!left.empty()) {
    const ssize_t written = ::write(descriptor_, left.data(), left.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    left.remove_prefix(static_cast<std::size_t>(written));
  }
  buffer_.clear();
}

void OutputFile::commit() {
  flush();
  if (temporary_.empty()) {
    if (::close(std::exchange(descriptor_, -1)) != 0) fail(errno);
    return;
  }
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != EROFS) fail(errno);
  if (::close(std::exchange(descriptor_, -1)) != 0 || ::rename(temporary_.c_str(), file_.c_str()) != 0) {
    const int error = errno;
    ::unlink(temporary_.c_str());
    throw InputError({.file = file_.string()}, fmt::format("cannot be written: {}", std::strerror(error)));
  }
}

}  // namespace forefeel
