#pragma once
// Shapes compared with tight solves at the same HIP positions, after the run:
//   error of a shape = max over its nodes |u~ - u| / max over its nodes |u|     [1]
// u~ the shape, u [m] the displacements of the solve. The largest displacement counts as at least 0.1 mm.

#include <cstddef>
#include <vector>

#include "geometry/coverage/coverage.hpp"
#include "scheduling/judge/stop_options.hpp"
#include "scheduling/log/session_result.hpp"
#include "scheduling/shape/shape_log.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

struct CheckedShape {
  std::size_t record = 0;      // of ShapeLog::records()
  Label label = Label::blank;  // of the frame at that time
  double error = 0;            // [1]
  double node_p95 = 0;         // 95th percentile over the nodes, relative to the same displacement [1]
};

// Compares options().checks shapes at even distances in time, by rising record; fewer where solves fail or the
// session was interrupted. The references must hold displacements. Adds a note to the result where shapes are
// left out.
std::vector<CheckedShape> check_shapes(const ShapeLog& log, ReferenceService& references,
                                       const StopOptions& stop, SessionResult& result,
                                       const ShowProgress& show);

}  // namespace forefeel
