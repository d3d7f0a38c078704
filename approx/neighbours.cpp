#include "approx/neighbours.hpp"

namespace forefeel {

NeighbourSelector::NeighbourSelector(const StateSpace& space, const ModelOptions& options)
    : space_(space), n_(options.neighbours), rule_(options.select) {}

Label NeighbourSelector::select(const Vec3& hip, std::vector<StateId>& out) {
  space_.nearest(hip, n_, out);
  return space_.coverage(hip).label;
}

void NeighbourSelector::forget() {}

}  // namespace forefeel
