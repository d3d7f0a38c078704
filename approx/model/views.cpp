#include "approx/model/views.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel::detail {

Views::Views() {
  for (int k = 0; k < pairs; ++k) {
    const double z = (k + 0.5) / pairs, r = std::sqrt(1 - z * z), angle = 2.399963229728653 * k;
    all.push_back(Vec3(r * std::cos(angle), r * std::sin(angle), z));
    all.push_back(-all.back());
  }
  const double least =
      std::cos(std::acos(turned) + std::sqrt(2.0) / grid);  // no cell reaches farther than that
  for (int face = 0; face < 6; ++face)
    for (int i = 0; i < grid; ++i)
      for (int j = 0; j < grid; ++j) {
        first_.push_back(about_.size());
        Vec3 centre;
        centre[face % 3] = face < 3 ? 1 : -1;
        centre[(face + 1) % 3] = (2 * i + 1) / double(grid) - 1;
        centre[(face + 2) % 3] = (2 * j + 1) / double(grid) - 1;
        centre.normalize();
        for (std::size_t k = 0; k < all.size(); ++k)
          if (centre.dot(all[k]) > least) about_.push_back(static_cast<std::uint16_t>(k));
      }
  first_.push_back(about_.size());
}

std::size_t Views::cell_of(const Vec3& u, int cells) {
  int axis = 0;
  if (std::abs(u[1]) > std::abs(u[axis])) axis = 1;
  if (std::abs(u[2]) > std::abs(u[axis])) axis = 2;
  const double half = 0.5 * cells, per = half / std::abs(u[axis]);
  const auto along = [&](int d) { return std::clamp(static_cast<int>(half + per * u[d]), 0, cells - 1); };
  const int face = u[axis] > 0 ? axis : axis + 3;
  return static_cast<std::size_t>((face * cells + along((axis + 1) % 3)) * cells + along((axis + 2) % 3));
}

std::span<const std::uint16_t> Views::of(const Vec3& u) const {
  const std::size_t at = cell_of(u, grid);
  return std::span(about_).subspan(first_[at], first_[at + 1] - first_[at]);
}

const Views& views() {
  static const Views made;
  return made;
}

}  // namespace forefeel::detail
