#include "geometry/states/writer_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "geometry/common/error.hpp"

namespace forefeel {

WriterLock::WriterLock(const std::filesystem::path& file) : path_(file.string() + "-lock") {
  for (;;) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      throw InputError({.file = file.string()}, fmt::format("cannot be written: {}", std::strerror(errno)));
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      const int error = errno;
      const std::string owner = read_owner();
      ::close(descriptor_);
      throw InputError({.file = file.string()},
                       error == EWOULDBLOCK
                           ? fmt::format("is being written by another process{}, expected one writer", owner)
                           : fmt::format("cannot be locked: {}", std::strerror(error)));
    }
    // The last owner may have removed the name between open and flock. Then this file is one that no other
    // process finds.
    struct stat ours {
    }, named{};
    if (::fstat(descriptor_, &ours) == 0 && ::stat(path_.c_str(), &named) == 0 &&
        ours.st_ino == named.st_ino && ours.st_dev == named.st_dev)
      break;
    ::close(descriptor_);
  }
  const std::string owner = fmt::format("{}\n", ::getpid());
  if (::ftruncate(descriptor_, 0) != 0 || ::pwrite(descriptor_, owner.data(), owner.size(), 0) < 0) {
    // Harmless: only the process number in the message of a second writer would be missing.
  }
}

WriterLock::~WriterLock() {
  ::unlink(path_.c_str());
  ::close(descriptor_);
}

std::string WriterLock::read_owner() const {
  char text[32] = {};
  const ssize_t n = ::pread(descriptor_, text, sizeof text - 1, 0);
  return n > 1 ? fmt::format(" ({})", std::string(text, static_cast<std::size_t>(n) - 1)) : std::string();
}

}  // namespace forefeel
