#pragma once
// Prints the share of the time for which a session knew the force within the tolerance of its scene.

#include <string>

#include "apps/console/document_keys.hpp"
#include "scheduling/record/tolerance_share.hpp"

namespace forefeel {

struct ToleranceShown {
  const ToleranceShare& share;
  const Tolerance& tolerance;
};
const JsonKeys<ToleranceShown>& tolerance_keys();  // of `tolerance` in summary.json
std::string tolerance_in_words(const ToleranceShare& share, const Tolerance& tolerance);

}  // namespace forefeel
