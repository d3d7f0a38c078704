#include "apps/study/study_toml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace forefeel::study_toml {

std::string toml_of(const toml::node& node) {
  std::ostringstream out;
  const auto flags = toml::toml_formatter::default_flags & ~toml::format_flags::allow_literal_strings &
                     ~toml::format_flags::allow_multi_line_strings &
                     ~toml::format_flags::allow_binary_integers & ~toml::format_flags::allow_octal_integers &
                     ~toml::format_flags::allow_hexadecimal_integers;
  node.visit([&](const auto& value) { out << toml::toml_formatter(value, flags); });
  std::string text = out.str();
  std::ranges::replace(text, '\n', ' ');
  return text;
}

namespace {

// Numbers in as few digits as read back to the same.
std::string brief(const toml::node& node) {
  if (const auto* number = node.as_floating_point(); number && std::isfinite(number->get())) {
    const std::string text = fmt::format("{}", number->get());
    return text.find_first_not_of("-0123456789") == std::string::npos ? text + ".0" : text;
  }
  const auto* list = node.as_array();
  if (!list || list->empty()) return toml_of(node);
  std::string text;
  for (const toml::node& element : *list) text += (text.empty() ? "[ " : ", ") + brief(element);
  return text + " ]";
}

}  // namespace

std::string shown(const toml::node& node) {
  const auto* text = node.as_string();
  return text ? text->get() : brief(node);
}

std::vector<std::pair<std::string, const toml::node*>> in_file_order(const toml::table& table) {
  std::vector<std::pair<std::string, const toml::node*>> entries;
  for (const auto& [key, value] : table) entries.emplace_back(std::string(key.str()), &value);
  std::ranges::stable_sort(entries, [](const auto& a, const auto& b) {
    const auto begin_a = a.second->source().begin, begin_b = b.second->source().begin;
    return std::pair(begin_a.line, begin_a.column) < std::pair(begin_b.line, begin_b.column);
  });
  return entries;
}

}  // namespace forefeel::study_toml
