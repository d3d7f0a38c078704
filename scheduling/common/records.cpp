#include "scheduling/common/records.hpp"

namespace forefeel {

std::string_view name(DispatchStatus status) {
  switch (status) {
    case DispatchStatus::running:
      return "running";
    case DispatchStatus::waiting:
      return "waiting";
    case DispatchStatus::solved:
      return "solved";
    case DispatchStatus::failed:
      return "failed";
    case DispatchStatus::arrived:
      return "arrived";
    case DispatchStatus::preempted:
      return "preempted";
    case DispatchStatus::withdrawn:
      return "withdrawn";
  }
  return "";
}

std::string_view name(SwitchCause cause) {
  switch (cause) {
    case SwitchCause::guess:
      return "guess";
    case SwitchCause::first:
      return "first";
    case SwitchCause::states:
      return "states";
    case SwitchCause::travel:
      return "travel";
  }
  return "";
}

}  // namespace forefeel
