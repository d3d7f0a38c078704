#pragma once
// What `forefeel bench coverage` measures beyond the indexes: the cost of keeping regions up to date, and how far the
// two indexes agree on the built-in setups.

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/console/console.hpp"

namespace forefeel {

struct RegionCost {
  std::string name;
  double look_us =
      0;  // one insertion, and the labels of the way 2 h ahead of it, every h/4, as a planner asks
  double whole_us = 0;  // and working out everything else that it may have changed; nothing is left pending
  std::size_t states = 0;
  double sum = 0;  // of the labels: keeps the optimiser honest
};

// Medians over insertions into n states; regions of 24 spacings a side around them, settled before each insertion.
//   path       along a path through a populated area
//   scattered  anywhere in an area where two thirds of the volume is sparse
//   front      states that leave the populated area into the blank
std::vector<RegionCost> bench_regions(std::size_t n, std::uint64_t seed);

// Key `agreement` and a table: every setup, with the widths 48 and 120 mm.
void report_agreement(const Globals& globals, nlohmann::ordered_json& out);

}  // namespace forefeel
