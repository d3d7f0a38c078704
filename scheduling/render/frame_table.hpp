#pragma once
// Checks that the table of frames (RUN/frames.csv) and the inputs (RUN/session.inputs) are of the same run. In each row
// the position, the rendered force and the force sent must be those of the recorded frame, digit for digit (both files
// have all digits of a double).

#include <cstddef>
#include <filesystem>

namespace forefeel {

// Returns the number of rows compared, 0 if there is no such table. A table that ends early is compared up to its end.
// Throws InputError with the first line of the table that is of another run.
std::size_t compare_frame_table(const std::filesystem::path& table, const std::filesystem::path& inputs);

}  // namespace forefeel
