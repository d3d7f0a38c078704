#include "scheduling/motion/trace_time.hpp"

#include <chrono>
#include <string>

#include "geometry/common/scanner.hpp"
#include "scheduling/motion/trace_cells.hpp"

namespace forefeel {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// Takes a number of `count` digits from the front of the text.
std::optional<int> digits(std::string_view& text, std::size_t count) {
  if (text.size() < count) return {};
  int value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_digit(text[i])) return {};
    value = 10 * value + (text[i] - '0');
  }
  text.remove_prefix(count);
  return value;
}

bool skip(std::string_view& text, char mark) {
  if (!text.starts_with(mark)) return false;
  text.remove_prefix(1);
  return true;
}

// ".fff" or ",fff"; 0 where there is none.
std::optional<double> fraction(std::string_view& text) {
  if (!skip(text, '.') && !skip(text, ',')) return 0;
  std::size_t count = 0;
  while (count < text.size() && is_digit(text[count])) ++count;
  double value = 0;
  if (count == 0 || !parse_real("0." + std::string(text.substr(0, count)), value)) return {};
  text.remove_prefix(count);
  return value;
}

// "hh:mm:ss.fff", "hh:mm", or both without the colons [s].
std::optional<double> time_of_day(std::string_view& text) {
  const auto hours = digits(text, 2);
  const bool colons = skip(text, ':');
  const auto minutes = digits(text, 2);
  if (!hours || !minutes || *hours > 24 || *minutes > 59) return {};
  const double start = 3600.0 * *hours + 60.0 * *minutes;
  if (colons ? !skip(text, ':') : text.empty() || !is_digit(text.front())) return start;
  const auto seconds = digits(text, 2);
  if (!seconds || *seconds > 60) return {};
  const auto rest = fraction(text);
  if (!rest) return {};
  return start + *seconds + *rest;
}

// "Z", "+hh:mm", "-hhmm", "+hh" or nothing: seconds ahead of UTC.
std::optional<double> zone(std::string_view text) {
  if (text.empty() || text == "Z" || text == "z") return 0;
  const double sign = text.front() == '-' ? -1 : 1;
  if (!skip(text, '+') && !skip(text, '-')) return {};
  const auto hours = digits(text, 2);
  skip(text, ':');
  const auto minutes = text.empty() ? std::optional(0) : digits(text, 2);
  if (!hours || !minutes || !text.empty()) return {};
  return sign * (3600.0 * *hours + 60.0 * *minutes);
}

std::optional<TraceTime> date_and_time(std::string_view text) {
  const auto year = digits(text, 4);
  const bool dashes = skip(text, '-');
  const auto month = digits(text, 2);
  if (dashes && !skip(text, '-')) return {};
  const auto day = digits(text, 2);
  if (!year || !month || !day) return {};
  if (!skip(text, 'T') && !skip(text, 't') && !skip(text, ' ')) return {};
  const std::chrono::year_month_day date(std::chrono::year(*year),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day)));
  const auto seconds = time_of_day(text);
  if (!date.ok() || !seconds) return {};
  const auto ahead = zone(text);
  if (!ahead) return {};
  return TraceTime{.day = std::chrono::sys_days(date).time_since_epoch().count(),
                   .seconds = *seconds - *ahead,
                   .dated = true};
}

}  // namespace

std::optional<TraceTime> trace_time(std::string_view cell) {
  double value = 0;
  if (trace_number(cell, value)) return TraceTime{.day = 0, .seconds = value, .dated = false};
  return date_and_time(cell);
}

}  // namespace forefeel
