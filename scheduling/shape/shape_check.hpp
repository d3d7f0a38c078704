#pragma once
// Compares shapes with tight solves at the same HIP positions, after the run:
//   error of a shape = max over its nodes |u~ - u| / max over its nodes |u|     [1]
// u~ [m]: displacements of the shape, u [m]: displacements of the solve. The denominator is at least 0.1 mm.

#include <cstddef>
#include <vector>

#include "geometry/coverage/coverage.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/judge/judging_options.hpp"
#include "scheduling/shape/shape_log.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

struct CheckedShape {
  std::size_t record = 0;      // of ShapeLog::records()
  Label label = Label::blank;  // of the frame at that time
  double error = 0;            // [1]
  double node_p95 = 0;         // 95th percentile over the nodes, relative to the same displacement [1]
};

// Compares log.options().checks shapes, evenly spaced in time. The result is sorted by record. A shape is skipped if
// its solve fails or if the interrupted session does not wait for it; a note in `result` says how many.
// The references must hold displacements.
std::vector<CheckedShape> check_shapes(const ShapeLog& log, ReferenceService& references,
                                       const StopOptions& stop, SessionResult& result,
                                       const ShowProgress& show);

}  // namespace forefeel
