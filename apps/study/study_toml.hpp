#pragma once
// TOML of a study: read from its file, and its values as text, for messages, for the table of the cells and
// for the scene's overrides.

#include <toml++/toml.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace forefeel::study_toml {

// InputError where the file cannot be read.
std::string read_text(const std::filesystem::path& file);
// InputError with the line where the text is no TOML.
toml::table parse(const std::string& text, const std::filesystem::path& file);

// The value as TOML in one line.
std::string toml_of(const toml::node& node);
// The same with numbers in as few digits as read back to the same, and a string without its quotes.
std::string shown(const toml::node& node);
// toml++ sorts keys; here what a person wrote first comes first.
std::vector<std::pair<std::string, const toml::node*>> in_file_order(const toml::table& table);

}  // namespace forefeel::study_toml
