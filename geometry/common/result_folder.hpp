#pragma once
// A folder that a command fills with several files. The user's own files in it are never replaced. A folder
// filled by forefeel holds the marker `.forefeel`, which lists the names of its files, one per line. Folders of
// older versions have no marker; they are recognised by their summary.json or study.json.

#include <filesystem>
#include <string>
#include <vector>

namespace forefeel {

// Makes the folder if it is missing, and writes the marker. names: of the files that will be made; "*.svg"
// stands for every name that ends in .svg. InputError if files cannot be written there, or if a file of one of
// the names exists and was not made by forefeel; then nothing is made or changed.
void claim_folder(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace forefeel
