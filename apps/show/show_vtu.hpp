#pragma once
// Files for ParaView of what `forefeel show` shows, in positions of the HIP [m].

#include <filesystem>
#include <vector>

#include "apps/show/show_content.hpp"

namespace forefeel {

// OUT.vtu: the body, with point data role (0 free, 1 clamp, 2 contact) and group_NAME. Beside it, where there are
// any: OUT_labels.vtu (regions), OUT_states.vtu, OUT_path.vtu (time, force, label, error). Without a body OUT.vtu
// holds the labels, or else the path. Returns the names of the files.
std::vector<std::filesystem::path> write_show_vtu(const std::filesystem::path& file,
                                                  const ShowContent& content);
// The names of these files, without writing them.
std::vector<std::filesystem::path> show_vtu_files(const std::filesystem::path& file,
                                                  const ShowContent& content);

}  // namespace forefeel
