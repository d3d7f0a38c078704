#pragma once
// "Did you mean": the known word nearest to a mistyped one.

#include <span>
#include <string>
#include <string_view>

namespace forefeel {

// Edit distance: least number of insertions, deletions, substitutions and swaps of neighbours (optimal string
// alignment). Ignores case.
std::size_t edit_distance(std::string_view a, std::string_view b);
// The nearest known word; of equally near ones the first. Empty if there are no known words.
std::string nearest_word(std::string_view word, std::span<const std::string> known);
// "a, b, c"
std::string listed(std::span<const std::string> words);

}  // namespace forefeel
