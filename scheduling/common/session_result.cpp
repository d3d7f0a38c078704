#include "scheduling/common/session_result.hpp"

#include <fmt/format.h>

#include "geometry/common/enum_names.hpp"

namespace forefeel {

std::string_view name(SessionPhase phase) {
  return name_in<SessionPhase::references>({"arrivals", "session", "labels", "references"}, phase);
}

std::string phase_in_words(const SessionProgress& progress) {
  if (progress.rehearsals == 0) return std::string(name(progress.phase));
  return fmt::format("rehearsal {} of {}, {}", progress.rehearsal, progress.rehearsals, name(progress.phase));
}

}  // namespace forefeel
