#pragma once
// Summarises the shapes of a run: `shape` in summary.json. Errors are defined in shape/shape_check.hpp.

#include <array>
#include <span>
#include <vector>

#include "scheduling/record/summary.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "scheduling/shape/shape_check.hpp"

namespace forefeel {

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
