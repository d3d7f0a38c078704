#pragma once
// A folder that a command fills with several files. Somebody's own files in it are never replaced: a folder
// that forefeel has filled holds the marker `.forefeel`, which lists the names of its files, one a line.
// Folders of versions without the marker are known by their summary.json or study.json.

#include <filesystem>
#include <string>
#include <vector>

namespace forefeel {

// Makes the folder if it is missing, and writes the marker. names: of the files that will be made; "*.svg"
// stands for every name with this end. InputError, and nothing is made or changed: files cannot be written
// there, or a file of one of the names is there already and was not made by forefeel.
void claim_folder(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace forefeel
