#pragma once
// Converts TOML values of a study to text: for messages, for the table of cells and for overrides of
// the scene.

#include <toml++/toml.h>

#include <string>
#include <utility>
#include <vector>

namespace forefeel::study_toml {

// The value as TOML in one line.
std::string toml_of(const toml::node& node);
// The same, with the shortest digits that read back to the same number, and strings without quotes.
std::string shown(const toml::node& node);
// The entries in the order of the file; toml++ itself sorts them by key.
std::vector<std::pair<std::string, const toml::node*>> in_file_order(const toml::table& table);

}  // namespace forefeel::study_toml
