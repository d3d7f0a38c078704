#include "scheduling/common/session_result.hpp"

#include <fmt/format.h>

namespace forefeel {

std::string_view name(SessionPhase phase) {
  switch (phase) {
    case SessionPhase::arrivals:
      return "arrivals";
    case SessionPhase::session:
      return "session";
    case SessionPhase::labels:
      return "labels";
    case SessionPhase::references:
      return "references";
  }
  return "";
}

std::string phase_in_words(const SessionProgress& progress) {
  if (progress.rehearsals == 0) return std::string(name(progress.phase));
  return fmt::format("rehearsal {} of {}, {}", progress.rehearsal, progress.rehearsals, name(progress.phase));
}

}  // namespace forefeel
