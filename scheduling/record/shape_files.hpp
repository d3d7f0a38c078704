#pragma once
// The files of the shapes of a run, for ParaView and `forefeel show`:
//   RUN/shape.pvd                    the times of the series
//   RUN/shape/shape_000000.vtu …     the moved nodes of each shape (geometry/mesh/vtu_series.hpp)
//   RUN/shape.csv                    a row for each shape
// They are written from the records, after the run. shape.pvd is written after all .vtu files: if it exists, the
// series is complete.

#include <filesystem>
#include <span>
#include <vector>

#include "geometry/common/declared.hpp"
#include "scheduling/shape/shape_check.hpp"

namespace forefeel {

// Removes the shapes of an earlier run in this folder, so that they are not mistaken for those of the new run.
void remove_shape_files(const std::filesystem::path& run);

// The series without its table. Throws InputError if a file cannot be written; nothing of it is left then.
void write_shape_series(const std::filesystem::path& run, const ShapeLog& log);
void write_shape_table(const std::filesystem::path& run, const ShapeLog& log,
                       std::span<const CheckedShape> checked);

DeclaredTable declared_shape_table();  // the columns of shape.csv

}  // namespace forefeel
