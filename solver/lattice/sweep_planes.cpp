#include "solver/lattice/sweep_planes.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {

bool CoarsePlanes::holds(const LatticeIndex& k) const {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::ranges::binary_search(at[axis], k[axis])) return false;
  return true;
}

std::optional<std::pair<int, int>> CoarsePlanes::around(std::size_t axis, double q) const {
  constexpr double rounding = 1e-6;
  const std::vector<int>& planes = at[axis];
  const auto high = std::ranges::lower_bound(planes, q - rounding, {}, [](int k) { return double(k); });
  if (high == planes.end()) return std::nullopt;
  if (*high <= q + rounding) return std::pair{*high, *high};
  if (high == planes.begin()) return std::nullopt;
  return std::pair{*(high - 1), *high};
}

std::optional<int> CoarsePlanes::next(std::size_t axis, int k, int side) const {
  const std::vector<int>& planes = at[axis];
  const auto here = std::ranges::lower_bound(planes, k);
  if (side < 0) return here == planes.begin() ? std::nullopt : std::optional(*(here - 1));
  return planes.end() - here < 2 ? std::nullopt : std::optional(*(here + 1));
}

std::vector<LatticeIndex> inner_corners(const CoarsePlanes& planes, const LatticeIndex& coarse) {
  std::vector<LatticeIndex> corners{coarse};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (coarse[axis] == 0) continue;
    const auto next = planes.next(axis, coarse[axis], coarse[axis] > 0 ? -1 : 1);
    if (!next) continue;
    for (std::size_t i = 0, count = corners.size(); i < count; ++i) {
      corners.push_back(corners[i]);
      corners.back()[axis] = *next;
    }
  }
  return corners;
}

CoarsePlanes coarse_planes(const Box& box, double spacing) {
  CoarsePlanes planes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // the first and the last position of lattice() (state_space.hpp)
    const auto i = static_cast<int>(axis);
    const int low = static_cast<int>(std::ceil(box.low[i] / spacing - 1e-9)),
              high = static_cast<int>(std::floor(box.high[i] / spacing + 1e-9));
    for (int k = low; k <= high; ++k)
      if (k % 2 == 0 || k == low || k == high) planes.at[axis].push_back(k);
  }
  return planes;
}

}  // namespace forefeel
