#include "geometry/meshing/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace forefeel {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void run_child(int out, pid_t parent, const std::function<int(int)>& work) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) ::signal(number, SIG_DFL);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) _exit(child_cut_short);  // it ended before the line above
  const int nowhere = ::open("/dev/null", O_RDWR);
  if (nowhere >= 0) ::dup2(nowhere, STDOUT_FILENO), ::dup2(nowhere, STDERR_FILENO);
  int code = child_threw;
  try {
    code = work(out);
  } catch (...) {
  }
  _exit(code);  // no destructors: the process ends here
}

enum class Read { all, late, stopped };

// Reads all that the child writes.
Read drain(int in, const ChildLimits& limits, std::string& data) {
  char block[1 << 16];
  for (;;) {
    if (limits.stop && limits.stop->load(std::memory_order_relaxed)) return Read::stopped;
    if (limits.tick) limits.tick();
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(limits.deadline - Clock::now()).count();
    if (left <= 0) return Read::late;
    pollfd wait{in, POLLIN, 0};
    const int ready = ::poll(&wait, 1, static_cast<int>(std::min<long long>(left, 100)));
    if (ready <= 0) continue;  // also after a signal
    const ssize_t n = ::read(in, block, sizeof block);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return Read::all;
    data.append(block, static_cast<std::size_t>(n));
  }
}

}  // namespace

bool write_to(int out, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = ::write(out, at, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += n, size -= static_cast<std::size_t>(n);
  }
  return true;
}

ChildOutcome run_apart(const ChildLimits& limits, const std::function<int(int out)>& work) {
  ChildOutcome outcome;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return outcome.code = errno, outcome;
  const pid_t parent = ::getpid(), child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    run_child(ends[1], parent, work);
  }
  const int error = errno;
  ::close(ends[1]);
  if (child < 0) return ::close(ends[0]), outcome.code = error, outcome;
  const Read read = drain(ends[0], limits, outcome.data);
  ::close(ends[0]);
  if (read != Read::all) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (read != Read::all) {
    outcome.end = read == Read::late ? ChildOutcome::End::late : ChildOutcome::End::stopped;
  } else if (WIFSIGNALED(status)) {
    outcome.end = ChildOutcome::End::signalled, outcome.code = WTERMSIG(status);
  } else {
    outcome.end = ChildOutcome::End::exited, outcome.code = WEXITSTATUS(status);
  }
  return outcome;
}

}  // namespace forefeel
