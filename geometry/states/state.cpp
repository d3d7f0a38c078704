#include "geometry/states/state.hpp"

namespace forefeel {

std::string_view name(SolveStatus status) {
  switch (status) {
    case SolveStatus::converged:
      return "converged";
    case SolveStatus::diverged:
      return "diverged";
    case SolveStatus::stalled:
      return "stalled";
    case SolveStatus::inverted:
      return "inverted";
    case SolveStatus::cancelled:
      return "cancelled";
    case SolveStatus::measured:
      return "measured";
  }
  return "unknown";
}

std::optional<SolveStatus> solve_status(std::string_view text) {
  for (int i = 0; i <= static_cast<int>(SolveStatus::measured); ++i)
    if (const auto status = static_cast<SolveStatus>(i); name(status) == text) return status;
  return std::nullopt;
}

}  // namespace forefeel
