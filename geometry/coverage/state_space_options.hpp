#pragma once
// Settings of a state space: spacing, box and the thresholds of the labels.

#include <memory>

#include "geometry/coverage/coverage.hpp"

namespace forefeel {

class AdaptiveLattice;

struct StateSpaceOptions {
  double spacing = 0.006;  // h [m]
  Box box{};               // where states are placed [m]; the HIP may leave it
  CoverageOptions coverage{};
  double merge_distance = 1e-9;  // states nearer than this count as one [spacings]
  // If given, labels use its h(q) instead of `spacing`, which then sets only the side of the finest regions
  // (spacing / 4) and the merge distance. Shared, never changed.
  std::shared_ptr<const AdaptiveLattice> lattice = nullptr;
};

}  // namespace forefeel
