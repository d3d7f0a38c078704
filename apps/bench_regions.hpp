#pragma once
// What `forefeel bench coverage` measures beyond the indexes: the cost of keeping regions up to date, and how far the
// two indexes agree on the built-in setups.

#include <cstdint>
#include <string>
#include <vector>

#include "apps/command.hpp"

namespace forefeel {

struct RegionCost {
  std::string name;
  double mark_us = 0;    // after one insertion: finding the leaves whose proof it breaks
  double whole_us = 0;   // and working all of them out again; nothing is left pending
  std::size_t states = 0;
};

// Medians over insertions into n states; regions of 24 spacings a side around them, settled before each insertion.
//   path       along a path through a populated area
//   scattered  anywhere in an area where two thirds of the volume is sparse
//   front      states that leave the populated area into the blank
std::vector<RegionCost> bench_regions(std::size_t n, std::uint64_t seed);

// Key `agreement` and a table: every setup, with the widths 48 and 120 mm.
void report_agreement(const Globals& globals, nlohmann::ordered_json& out);

}  // namespace forefeel
