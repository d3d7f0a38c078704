#pragma once
// Halton's low-discrepancy sequence in three dimensions: radical inverses of i in the bases 2, 3 and 5,
//   i = sum_k d_k b^k  ->  sum_k d_k b^(-k-1),   spread over a box.

#include <cstddef>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

inline double radical_inverse(std::size_t i, std::size_t base) {
  double value = 0, digit = 1;
  for (; i > 0; i /= base) {
    digit /= static_cast<double>(base);
    value += digit * static_cast<double>(i % base);
  }
  return value;
}

// The first n points from i = 1 on [m].
inline std::vector<Vec3> halton_points(const Box& box, std::size_t n) {
  std::vector<Vec3> points;
  for (std::size_t i = 1; i <= n; ++i) {
    const Vec3 share(radical_inverse(i, 2), radical_inverse(i, 3), radical_inverse(i, 5));
    points.push_back(box.low + box.size().cwiseProduct(share));
  }
  return points;
}

}  // namespace forefeel
