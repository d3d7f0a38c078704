#pragma once
// A small view of the shapes of a run in its report: the surface of the body, turned with the pointer, over time.

#include <string>

#include "scheduling/record/shape_summary.hpp"

namespace forefeel {

// HTML with its own script and data; it needs no other file.
std::string shape_view(const ShapeLog& log, const ShapeSummary& summary);

}  // namespace forefeel
