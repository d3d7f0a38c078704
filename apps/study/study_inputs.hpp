#pragma once
// What a study runs on: its scenes (the file of one, or a list of files in one folder, to which the values that name
// files are relative), its seeds, and the speeds that it tries.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "apps/study/study_toml.hpp"
#include "scheduling/study/study.hpp"

namespace forefeel {

// At least one. InputError names the study's line.
std::vector<std::filesystem::path> study_scenes(const toml::node* node, const std::filesystem::path& study);
// At least one, each once.
std::vector<std::uint64_t> study_seeds(const toml::node* node, const std::filesystem::path& study);
SustainedOptions study_sustained(const toml::table& table, const std::filesystem::path& study);

}  // namespace forefeel
