#pragma once
// The tasks of a sweep for its threads. A task starts as soon as those that it waits for are done. A thread without a
// task helps with the solves under way: large bodies share out their factors and elements (share_out.hpp).

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <queue>
#include <tuple>
#include <vector>

#include "solver/lattice/generate.hpp"
#include "solver/lattice/sweep_plan.hpp"
#include "solver/system/share_out.hpp"

namespace forefeel {

double wall_seconds(std::chrono::steady_clock::time_point start);
// Processor time of this thread: other programs do not lengthen it [s].
double thread_seconds();

// What a thread does without a pause. The steps of a cell are those of SweepCell: its hard states do not wait for each
// other.
enum class TaskStep {
  all,
  correct,
  find_paths,
  follow_path
};  // all: of a coarse node; of a cell the first step
struct LatticeTask {
  std::size_t piece = 0;
  TaskStep step = TaskStep::all;
  std::size_t place = 0;                      // in SweepCell::open
  double begins = 0;                          // the earliest time with any number of threads [s]
  std::shared_ptr<SweepCell> cell = nullptr;  // once begun

  // Those of a cell begun come first, as nothing else may be left to share out at the end; then outward from rest.
  auto order() const { return std::tuple(step == TaskStep::all, piece, place); }
};

// What may start once a task is done: so many tasks of that step, side by side.
struct NextTasks {
  TaskStep step = TaskStep::all;
  std::size_t count = 0;
  std::shared_ptr<SweepCell> cell = nullptr;
};

// Hands each task to a thread as soon as those that it waits for are done: coarse nodes first, outward from rest.
class TaskQueue {
 public:
  // One thread's.
  class Member : public Crew {
   public:
    explicit Member(TaskQueue& queue) : queue_(queue) {}
    void share(std::size_t count, const std::function<void(std::size_t)>& part) override;

   private:
    friend TaskQueue;
    TaskQueue& queue_;
    double shared_ = 0,
           longest_ = 0;  // of this task: seconds in parts of this thread; of the longest part of each share
  };

  explicit TaskQueue(std::vector<SweepPiece> pieces);
  const SweepPiece& piece(std::size_t id) const { return pieces_[id]; }

  // Waits for a task, and helps meanwhile. Nothing if all are done, or once `stopped` is true.
  std::optional<LatticeTask> take(const std::function<bool()>& stopped);
  // seconds: of this thread. next: of the same piece, once all tasks beside this one are done too; none: the piece is
  // solved then
  void done(const LatticeTask& task, double seconds, Member& by, const NextTasks& next);
  // After `stopped` became true. Under the lock, so that no thread falls asleep between its look and this call.
  void wake();

  // before: seconds before the first piece; in_sink: seconds in the sink, one call after another
  ParallelTimes times(double before, double in_sink) const;

 private:
  struct Progress {
    std::size_t open = 1;  // tasks of the step under way that are not done
    double end = 0;        // of those done, with any number of threads [s]
  };
  struct Later {
    bool operator()(const LatticeTask& a, const LatticeTask& b) const { return b.order() < a.order(); }
  };
  // What a solve shares out.
  struct Share {
    const std::function<void(std::size_t)>& part;
    std::size_t count;
    std::atomic<std::size_t> next = 0;
    std::size_t helpers = 0;
    double longest = 0;  // of the helpers' parts [s]
    struct Times {
      double all, longest;
    };
    Times run();  // the parts that are left
  };

  void finish(std::size_t id, double end);
  Share* open_share();
  void help(Share& share, std::unique_lock<std::mutex>& lock);

  std::vector<SweepPiece> pieces_;
  std::priority_queue<LatticeTask, std::vector<LatticeTask>, Later> ready_;
  std::vector<Progress> at_;  // by piece
  std::size_t left_;          // pieces not solved
  std::vector<Share*> shares_;
  std::atomic<int> free_ = 0;  // threads that wait or help
  ParallelTimes times_ = {};   // path: of the pieces
  std::mutex mutex_;
  std::condition_variable changed_;
};

}  // namespace forefeel
