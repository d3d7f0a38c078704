#pragma once
// The neighbour set of a HIP (design: the states whose data the current model uses).
//   nearest   the n nearest (paper 3.1)
//   label     by the label of the HIP

#include <vector>

#include "approx/model.hpp"

namespace forefeel {

class NeighbourSelector {
 public:
  NeighbourSelector(const StateSpace& space, const ModelOptions& options);
  // At most options.neighbours ids, unordered, into `out`; returns the label of the HIP.
  Label select(const Vec3& hip, std::vector<StateId>& out);
  void forget();   // drops hysteresis

 private:
  const StateSpace& space_;
  std::size_t n_;
  Select rule_;
};

}  // namespace forefeel
