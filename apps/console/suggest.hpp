#pragma once
// "Did you mean": the known word nearest to a mistyped one.

#include <span>
#include <string>
#include <string_view>

namespace forefeel {

// Edit distance: least number of insertions, deletions, substitutions and swaps of neighbours (optimal string
// alignment). Ignores case.
std::size_t edit_distance(std::string_view a, std::string_view b);
// The nearest known word; of equally near ones, the first. Empty if no word is near. Near means: within two edits (and
// fewer edits than the word has letters), or within a third of the word's length.
std::string nearest_word(std::string_view word, std::span<const std::string> known);
// The end of an error about an unknown word: ", did you mean 'policy'? Expected one of a, b, c", without the question
// if no known word is near. The suggested word is put between `before` and `after`.
std::string expected_instead(std::string_view word, std::span<const std::string> known,
                             std::string_view before = "", std::string_view after = "");
// "a, b, c"
std::string listed(std::span<const std::string> words);

}  // namespace forefeel
