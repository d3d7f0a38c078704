#include "scheduling/session/memory_need.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "geometry/common/error.hpp"
#include "geometry/common/memory.hpp"
#include "geometry/common/threads.hpp"
#include "scheduling/common/records.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {
namespace {

// A frame's record; its label, sample and position with the judge and the pipeline; its row of frames.csv,
// which is made in memory.
constexpr double bytes_per_frame = sizeof(FrameRecord) + 160 + 400;
constexpr double bytes_per_thread = 256e3;  // stack as far as it is used, buffers of the allocator
constexpr int unchecked = 8;                // up to this number of solvers, no memory check is made
constexpr int most_threads = 4096;
constexpr int others = 8;  // threads of a session that do not solve: loop, planner, writers

void check_threads(int workers) {
  if (workers <= 1) return;
  const int start = threads_that_start(workers + others) - others;
  if (start < workers)
    throw InputError(
        "session.workers",
        fmt::format("is {}, each a thread under the real clock, and the limits of this process or "
                    "of its memory (ulimit -u, -v) allow {}, expected at most so many",
                    workers, std::max(start, 0)));
}

}  // namespace

MemoryNeed memory_need(const MemoryRequest& asked) {
  MemoryNeed need{.frames = static_cast<double>(asked.frames) * bytes_per_frame};
  const int workers = asked.workers, threads = reference_threads(asked.threads);
  if (std::max(workers, threads) <= unchecked) return need;
  double solver = 0;
  if (!is_linear(*asked.body))
    solver = static_cast<double>(SolverBasis(asked.body).bytes_per_solver(asked.jet));
  need.workers = workers * (solver + bytes_per_thread);
  need.references = threads * (solver + bytes_per_thread);
  return need;
}

void check_memory(const MemoryRequest& asked, double available) {
  const int workers = asked.workers, threads = reference_threads(asked.threads);
  if (workers > most_threads)
    throw InputError(
        "session.workers",
        fmt::format("is {}, and under the real clock each worker is a thread, expected at most {}", workers,
                    most_threads));
  const MemoryNeed need = memory_need(asked);
  if (need.all() <= available) return check_threads(workers);
  const double seconds = asked.seconds;
  const double most = std::max({need.frames, need.workers, need.references});
  const double left = std::max(0.0, available - (need.all() - most));  // for what takes the most
  const auto refuse = [&](const char* key, const std::string& what, double wanted, double floor) {
    throw InputError(
        key, fmt::format("is {:g}, and {} take about {} of memory, {} are free, expected at most {:g}",
                         wanted, what, bytes_in_words(most), bytes_in_words(available),
                         std::max(floor, std::floor(wanted * left / most))));
  };
  if (most == need.frames)
    refuse("session.seconds", fmt::format("{} frames", asked.frames), seconds, 1);
  else if (most == need.workers)
    refuse("session.workers", "the solvers of so many workers", workers, 1);
  else
    refuse("session.threads", "the solvers of so many threads", threads, 1);
}

}  // namespace forefeel
