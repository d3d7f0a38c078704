#pragma once
// The messages between rank 0 and the ranks that solve.
//   rank 0 -> r   begin (load the input) · job (number, content) · cancel · answer · beat · stop
//   r -> rank 0   ready (identity) · result (number of the job, content) · question · failure (text) · beat · left, the
//                 last one
// Every rank sends a heartbeat each half second, also while it loads or solves. If a rank is silent for longer than the
// patience of rank 0, it counts as hanging, and others get its work. If rank 0 is silent for orphaned_seconds, the
// other ranks end.

#include <chrono>

namespace forefeel {

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
