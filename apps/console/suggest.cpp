#include "apps/console/suggest.hpp"

#include <algorithm>
#include <cctype>
#include <limits>
#include <vector>

namespace forefeel {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0 : 1)});
      const bool swapped =
          i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

std::string nearest_word(std::string_view word, std::span<const std::string> known) {
  std::string best;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  const std::size_t few = word.empty() ? 0 : std::min<std::size_t>(2, word.size() - 1);
  return !best.empty() && least <= std::max(few, word.size() / 3) ? best : std::string();
}

std::string expected_instead(std::string_view word, std::span<const std::string> known,
                             std::string_view before, std::string_view after) {
  const std::string nearest = nearest_word(word, known);
  if (nearest.empty()) return ", expected one of " + listed(known);
  return ", did you mean '" + std::string(before) + nearest + std::string(after) + "'? Expected one of " +
         listed(known);
}

std::string listed(std::span<const std::string> words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace forefeel
