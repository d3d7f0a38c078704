#pragma once
// The keys that the benches print with --json, as in apps/console/document_keys.hpp.

#include <vector>

#include "geometry/common/declared.hpp"

namespace forefeel {

std::vector<DeclaredTable> declared_bench_json();  // one table for each bench

}  // namespace forefeel
