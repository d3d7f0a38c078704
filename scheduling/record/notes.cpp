#include "scheduling/record/notes.hpp"
#include "geometry/common/counted.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cstddef>
#include <map>

namespace forefeel {
namespace {

bool is_digit(const std::string& text, std::size_t i) {
  return i < text.size() && std::isdigit(static_cast<unsigned char>(text[i])) != 0;
}

// The end of the number that begins at a digit.
std::size_t end_of_number(const std::string& text, std::size_t i) {
  while (is_digit(text, i) || (i < text.size() && text[i] == '.' && is_digit(text, i + 1))) ++i;
  if (i < text.size() && (text[i] == 'e' || text[i] == 'E')) {
    const bool is_signed = i + 1 < text.size() && (text[i + 1] == '-' || text[i + 1] == '+');
    if (is_digit(text, i + 1) || (is_signed && is_digit(text, i + 2))) {
      i += is_signed ? 2 : 1;
      while (is_digit(text, i)) ++i;
    }
  }
  return i;
}

// The line with "#" for each number and its sign.
std::string kind_of(const std::string& line) {
  std::string kind;
  for (std::size_t i = 0; i < line.size();) {
    if (!is_digit(line, i)) {
      kind += line[i++];
      continue;
    }
    if (!kind.empty() && (kind.back() == '-' || kind.back() == '+')) kind.pop_back();
    kind += '#';
    i = end_of_number(line, i);
  }
  return kind;
}

}  // namespace

std::vector<std::string> shortened_notes(std::span<const std::string> notes) {
  constexpr std::size_t most = 3;
  std::map<std::string, std::size_t> count, seen;
  for (const std::string& note : notes) ++count[kind_of(note)];
  std::vector<std::string> lines;
  for (const std::string& note : notes) {
    const std::string kind = kind_of(note);
    const std::size_t all = count[kind], before = seen[kind]++;
    if (all <= most)
      lines.push_back(note);
    else if (before == 0)
      lines.push_back(fmt::format("{} (and {} like this)", note, counted(all - 1, "more line")));
  }
  return lines;
}

std::vector<std::string> notes_in_common(std::span<const std::vector<std::string>> sessions) {
  struct Kind {
    std::string first;
    std::size_t lines = 0, sessions = 0, last = 0;  // last: number of the last session, from 1
  };
  std::vector<Kind> kinds;
  std::map<std::string, std::size_t> place;
  for (std::size_t s = 0; s < sessions.size(); ++s)
    for (const std::string& note : sessions[s]) {
      const auto [found, fresh] = place.try_emplace(kind_of(note), kinds.size());
      if (fresh) kinds.push_back({.first = note});
      Kind& kind = kinds[found->second];
      ++kind.lines;
      if (kind.last != s + 1) ++kind.sessions;
      kind.last = s + 1;
    }
  std::vector<std::string> lines;
  for (const Kind& kind : kinds)
    lines.push_back(fmt::format(
        "{} of {}: {}{}", kind.sessions, counted(sessions.size(), "cell"), kind.first,
        kind.lines > 1 ? fmt::format(" (and {} like this)", counted(kind.lines - 1, "more line")) : ""));
  return lines;
}

}  // namespace forefeel
