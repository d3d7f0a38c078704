#pragma once
// Whether the table of frames of a run (RUN/frames.csv) and its inputs (RUN/session.inputs) are of the same run: row by
// row the position, the rendered force and the force sent must be those of the recorded frames, digit for digit (both
// hold all digits of a double).

#include <cstddef>
#include <filesystem>

namespace forefeel {

// Returns the number of rows compared, 0 if there is no such table. A table that ends early is compared as far as it
// goes. InputError names the first line of the table that is of another run.
std::size_t compare_frame_table(const std::filesystem::path& table, const std::filesystem::path& inputs);

}  // namespace forefeel
