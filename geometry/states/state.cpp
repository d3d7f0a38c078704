#include "geometry/states/state.hpp"

#include "geometry/common/enum_names.hpp"

namespace forefeel {

std::string_view name(SolveStatus status) {
  return name_in<SolveStatus::measured>(
      {"converged", "diverged", "stalled", "inverted", "cancelled", "measured"}, status);
}

std::optional<SolveStatus> solve_status(std::string_view text) {
  for (int i = 0; i <= static_cast<int>(SolveStatus::measured); ++i)
    if (const auto status = static_cast<SolveStatus>(i); name(status) == text) return status;
  return std::nullopt;
}

}  // namespace forefeel
