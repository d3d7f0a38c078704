#pragma once
// Messages between the processes (ranks) of one run. Rank 0 gives out work, the others solve. Calls come from one
// thread at a time and never wait for another rank.

#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "geometry/common/packer.hpp"

namespace forefeel {

struct Message {
  int rank = 0;  // the sender
  int tag = 0;
  Bytes bytes;
};

class Transport {
 public:
  virtual ~Transport() = default;
  virtual int rank() const = 0;  // of this process
  virtual int ranks() const = 0;
  // Messages from one rank to another arrive in their order. To a rank that hangs, they wait here.
  virtual void send(int rank, int tag, Bytes bytes) = 0;
  virtual std::optional<Message> receive() = 0;  // nullopt: none is there
};

// Passes the answers that a rank receives to the function that is set. For any thread.

class RankListener {
 public:
  using Receive = std::function<void(Bytes)>;
  void set(Receive receive) {
    const std::lock_guard lock(mutex_);
    receive_ = std::move(receive);
  }
  void receive(Bytes answer) {
    const std::lock_guard lock(mutex_);
    if (receive_) receive_(std::move(answer));
  }

 private:
  std::mutex mutex_;
  Receive receive_;
};

// The messages between rank 0 and the ranks that solve.
//   rank 0 -> r   begin (load the input) · job (number, content) · cancel · answer · beat · stop
//   r -> rank 0   ready (identity) · result (number of the job, content) · question · failure (text) · beat · left, the
//                 last one
// Every rank sends a heartbeat each half second, also while it loads or solves. If a rank is silent for longer than the
// patience of rank 0, it counts as hanging, and others get its work. If rank 0 is silent for orphaned_seconds, the
// other ranks end.

enum class RankTag : int {
  begin = 1,
  job,
  cancel,
  answer,
  stop,
  ready,
  result,
  question,
  failure,
  beat,
  left
};

inline constexpr std::chrono::microseconds poll_pause{300};
inline constexpr double longest_step =
    0.1;  // [s] counted between two polls; in any longer time the process was stopped
inline constexpr double beat_seconds = 0.5, orphaned_seconds = 120;

// Throws InputError with key --patience.
void check_patience(double seconds);

}  // namespace forefeel
