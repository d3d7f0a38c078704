#include "geometry/states/writer_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

[[noreturn]] void refuse(const std::string& file, int error, const std::string& owner) {
  throw InputError({.file = file},
                   error == EWOULDBLOCK
                       ? fmt::format("is being written by another process{}, expected one writer", owner)
                       : fmt::format("cannot be locked: {}", std::strerror(error)));
}

void refuse_several_names(const std::string& file) {
  const std::size_t names = names_of(file);
  if (names > 1)
    throw InputError({.file = file},
                     fmt::format("has {} names (hard links), expected one: states that are written go to a "
                                 "log beside one name, and the others would miss them",
                                 names));
}

bool is_on_network(int descriptor) {
  constexpr unsigned long nfs = 0x6969, smb = 0x517b, cifs = 0xff534d42, smb2 = 0xfe534d42;
  struct statfs system {};
  if (::fstatfs(descriptor, &system) != 0) return true;
  const auto type = static_cast<unsigned long>(system.f_type) & 0xffffffffu;
  return type == nfs || type == smb || type == cifs || type == smb2;
}

}  // namespace

WriterLock::WriterLock(const std::filesystem::path& file)
    : file_(file.string()), path_(file.string() + "-lock") {
  refuse_several_names(file_);
  lock_name();
}

void WriterLock::lock_name() {
  for (;;) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      throw InputError({.file = file_}, fmt::format("cannot be written: {}", std::strerror(errno)));
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      const int error = errno;
      const std::string owner = read_owner();
      ::close(descriptor_);
      refuse(file_, error, owner);
    }
    // The last owner may have removed the name between open and flock. No other process can then find this file, so the
    // lock is useless.
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
  if (target_ >= 0) ::close(target_);
  ::unlink(path_.c_str());
  ::close(descriptor_);
}

void WriterLock::take_file() {
  target_ = ::open(file_.c_str(), O_RDONLY | O_CLOEXEC);
  if (target_ < 0) throw InputError({.file = file_}, fmt::format("cannot be read: {}", std::strerror(errno)));
  if (!is_on_network(target_) && ::flock(target_, LOCK_EX | LOCK_NB) != 0) refuse(file_, errno, "");
  refuse_several_names(file_);  // a name that was added meanwhile
}

std::string WriterLock::read_owner() const {
  char text[32] = {};
  const ssize_t n = ::pread(descriptor_, text, sizeof text - 1, 0);
  return n > 1 ? fmt::format(" ({})", std::string(text, static_cast<std::size_t>(n) - 1)) : std::string();
}

std::size_t names_of(const std::filesystem::path& file) {
  struct stat status {};
  return ::stat(file.c_str(), &status) == 0 ? static_cast<std::size_t>(status.st_nlink) : 0;
}

bool is_being_written(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool held = !is_on_network(descriptor) && ::flock(descriptor, LOCK_SH | LOCK_NB) != 0;
  ::close(descriptor);
  return held;
}

}  // namespace forefeel
