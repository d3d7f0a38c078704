#pragma once
// Reads dispatch.csv, the table of the solves of a run (scheduling/record/run_files.hpp writes it).

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

// One row. Numbers that the file leaves empty are NaN.
struct DispatchRow {
  Vec3 at = Vec3::Zero();               // position of the state [m]
  Vec3 site = Vec3::Constant(unknown);  // of a body that is touched anywhere [m]
  double finished = 0;                  // end of the solve [s]
  double known = 0;      // when the state became known [s]; NaN also in files without that column
  std::string status;    // name of a DispatchStatus (records.hpp)
  std::size_t line = 0;  // in the file, from 1

  bool became_known() const;  // the status is solved or arrived
};

// Rows in the order of the file. InputError with file and line if the file is missing, a column x, y, z,
// finished or status is missing, or a row differs from the header in length.
std::vector<DispatchRow> read_dispatch(const std::filesystem::path& file);

}  // namespace forefeel
