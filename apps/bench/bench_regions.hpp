#pragma once
// Two further measurements of `forefeel-bench coverage`: the cost of regions, and the agreement of the two
// indexes on the built-in setups.

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/console/console.hpp"

namespace forefeel {

struct RegionCost {
  std::string name;
  double look_us = 0;   // after an insertion, the labels of regions every h/4 over the next 2 h of the path
  double whole_us = 0;  // all regions
  std::size_t states = 0;
  double sum = 0;  // of the labels, so that the compiler does not remove the work
};

// Medians over insertions into n states. The regions have 24 spacings a side. setup:
//   path       along a path through a populated area
//   scattered  anywhere in an area where two thirds of the volume is sparse
//   front      states that advance from the populated area into the blank
std::vector<RegionCost> bench_regions(std::size_t n, std::uint64_t seed);

// The JSON key `agreement` and a table: every built-in setup, at widths of 48 and 120 mm.
void report_agreement(const Globals& globals, nlohmann::ordered_json& out);

}  // namespace forefeel
