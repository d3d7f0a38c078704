#include "scheduling/common/records.hpp"

#include "geometry/common/enum_names.hpp"

namespace forefeel {

std::string_view name(DispatchStatus status) {
  return name_in<DispatchStatus::withdrawn>(
      {"running", "waiting", "solved", "failed", "arrived", "preempted", "withdrawn"}, status);
}

std::string_view name(TouchKind kind) {
  return name_in<TouchKind::slip>({"none", "stick", "slip"}, kind);
}

std::string_view name(SwitchCause cause) {
  return name_in<SwitchCause::travel>({"guess", "first", "states", "travel"}, cause);
}

}  // namespace forefeel
