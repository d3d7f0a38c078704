#pragma once
// Reads the time of a sample: a number, or a date and time as in ISO 8601,
//   2021-08-18T15:05:42.250Z   2021-08-18 15:05:42,25   20210818T150542   2021-08-18T15:05:42+02:00
// The seconds of a date and time count from the beginning of that day in UTC. The day, counted from 1970-01-01, is a
// separate number, so that no digits are lost. A time without a zone counts as UTC; leap seconds are ignored.

#include <cstdint>
#include <optional>
#include <string_view>

namespace forefeel {

struct TraceTime {
  std::int64_t day = 0;  // days since 1970-01-01; 0 for a plain number
  double seconds = 0;    // of a plain number: in the unit of the file
  bool dated = false;    // a date and time, in seconds whatever the unit
};

// Unset for other text, and for a date that does not exist.
std::optional<TraceTime> trace_time(std::string_view cell);

}  // namespace forefeel
