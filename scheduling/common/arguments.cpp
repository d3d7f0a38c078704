#include "scheduling/common/arguments.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace forefeel {
namespace {

std::string called(const std::string& key) {
  return key.empty() ? "the text after the colon" : key;
}

}  // namespace

std::string to_text(const Registered& part) {
  std::string text = part.name;
  for (std::size_t i = 0; i < part.settings.size(); ++i) {
    const auto& [key, value] = part.settings[i];
    text += (i == 0 ? ':' : ',') + (key.empty() ? value : key + '=' + value);
  }
  return text;
}

Arguments::Arguments(InputPlace place, const PartSettings& settings) : place_(std::move(place)) {
  for (const auto& [key, value] : settings)
    if (!values_.emplace(key, value).second)
      throw InputError(place_, fmt::format("'{}' is given twice, expected it once", key));
}

bool Arguments::has(const std::string& key) {
  read_.insert(key);
  return values_.contains(key);
}

double Arguments::number(const std::string& key, double fallback, double low, double high) {
  if (!has(key)) return fallback;
  const std::string& text = values_.at(key);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    throw InputError(place_, fmt::format("{} is '{}', expected a number", called(key), text));
  if (value < low || value > high)
    throw InputError(place_, fmt::format("{} is {}, expected {} to {}", called(key), text, low, high));
  return value;
}

std::string Arguments::text(const std::string& key, std::string fallback) {
  return has(key) ? values_.at(key) : std::move(fallback);
}

std::vector<std::string> Arguments::keys() const {
  std::vector<std::string> all;
  for (const auto& [key, value] : values_) all.push_back(key);
  return all;
}

std::string Arguments::required_text(const std::string& key) {
  if (!has(key) || values_.at(key).empty())
    throw InputError(place_,
                     fmt::format("{} is missing, expected {}", called(key),
                                 key.empty() ? std::string("a text after the colon") : key + "=TEXT"));
  return values_.at(key);
}

void Arguments::expect_all_read() const {
  for (const auto& [key, value] : values_) {
    if (read_.contains(key)) continue;
    std::string known;
    for (const std::string& name : read_)
      if (!name.empty()) known += (known.empty() ? "" : ", ") + name;
    throw InputError(place_, fmt::format("unknown setting '{}', expected {}", key.empty() ? value : key,
                                         known.empty() ? "none" : known));
  }
}

}  // namespace forefeel
