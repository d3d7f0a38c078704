#pragma once
// The files of the shapes of a run, for ParaView and `forefeel show`:
//   RUN/shape.pvd                    the times of the series
//   RUN/shape/shape_000000.vtu …     the moved nodes of each shape (geometry/mesh/vtu_series.hpp)
//   RUN/shape.csv                    a row for each shape
// They are written from the records, after the run. shape.pvd is written after all .vtu files: if it exists, the
// series is complete.

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "geometry/common/declared.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "scheduling/shape/shape_check.hpp"

namespace forefeel {

// Removes the shapes of an earlier run in this folder, so that they are not mistaken for those of the new run.
void remove_shape_files(const std::filesystem::path& run);

// The series without its table. Throws InputError if a file cannot be written; nothing of it is left then.
void write_shape_series(const std::filesystem::path& run, const ShapeLog& log);
void write_shape_table(const std::filesystem::path& run, const ShapeLog& log,
                       std::span<const CheckedShape> checked);

DeclaredTable declared_shape_table();  // the columns of shape.csv

// Summarises the shapes of a run: `shape` in summary.json. Errors are defined in shape/shape_check.hpp.

struct ShapeSummary {
  struct Errors {
    std::size_t samples = 0;
    double p50 = unknown, p95 = unknown, max = unknown;  // [1]
  };
  double rate = 0;  // [Hz]
  bool surface = true;
  std::size_t nodes = 0, shapes = 0, missed = 0;
  std::array<std::size_t, 3> orders{};  // shapes of each ShapeOrder
  double largest = 0;                   // largest displacement of a node [m]
  SessionSummary::Timing cost_us;       // of a shape; real clock
  Errors error;                         // of the worst node of each compared shape
  Errors nodes_p95;                     // of the 95th percentile over the nodes of each compared shape
  ByLabel<Errors> by_label;             // of error
};

ShapeSummary summarise(const ShapeLog& log, std::span<const CheckedShape> checked);

// Named values with units and meanings, keys joined by dots, as in summary_columns.hpp.
std::vector<Column> shape_columns(const ShapeSummary& summary);

}  // namespace forefeel
