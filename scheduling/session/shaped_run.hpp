#pragma once
// The shapes of a session: input and result of run_session() with shapes (shaped_session.hpp).

#include <memory>
#include <vector>

#include "scheduling/shape/shape_check.hpp"
#include "scheduling/shape/shape_log.hpp"

namespace forefeel {

struct ShapedRun {
  std::shared_ptr<ShapeLog> log;           // of the touched body
  std::vector<CheckedShape> checked = {};  // filled by the run, by rising record
};

}  // namespace forefeel
