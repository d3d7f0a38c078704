#pragma once
// States from a table whose columns have other names, such as the recording of a robot.

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/states/state_file.hpp"

namespace forefeel {

// Columns of a file that hold x, y, z [m], and one value or fx, fy, fz [N] where there are more, in this order. A '-'
// before a name turns the sign, as for forces of the tip on the body.
using NamedColumns = std::vector<std::string>;

inline constexpr std::array<const char*, 9> stiffness_columns{"k11", "k12", "k13", "k21", "k22",
                                                              "k23", "k31", "k32", "k33"};

// "current_x,current_y,current_z,-force_x,-force_y,-force_z"; InputError("--columns", …) unless there are three, four
// or six different names.
NamedColumns named_columns(std::string_view text);

// What these columns tell; the others are ignored. InputError names file and line.
StateTable read_table_csv(const std::filesystem::path& file, const NamedColumns& columns);

}  // namespace forefeel
