#include "apps/picture/coverage_slice.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {
namespace {

constexpr std::size_t most_states = 6000;  // more would hide the colours

void cut_body(const CoveragePicture& picture, Slice& slice) {
  const double level = picture.through[slice.normal];
  for (const auto& triangle : picture.body) {
    std::vector<Eigen::Vector2d> crossing;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 &a = triangle[i], &b = triangle[(i + 1) % 3];
      const double da = a[slice.normal] - level, db = b[slice.normal] - level;
      if ((da < 0) == (db < 0)) continue;
      const Vec3 p = a + (b - a) * (da / (da - db));
      crossing.emplace_back(p[slice.u], p[slice.v]);
    }
    if (crossing.size() == 2) slice.outline.push_back({crossing[0], crossing[1]});
  }
}

}  // namespace

Slice cut(const CoveragePicture& picture, int normal) {
  Slice slice;
  slice.normal = normal;
  slice.u = normal == 0 ? 1 : 0;
  slice.v = normal == 2 ? 1 : 2;
  const Vec3 size = picture.box.size();
  const double width = std::max(size[slice.u], picture.spacing),
               height = std::max(size[slice.v], picture.spacing);
  slice.pixel = std::max(picture.spacing / 8, std::max(width, height) / slice_panel);
  slice.columns = std::max(1, static_cast<int>(std::ceil(width / slice.pixel - 1e-6)));
  slice.rows = std::max(1, static_cast<int>(std::ceil(height / slice.pixel - 1e-6)));
  slice.label.resize(static_cast<std::size_t>(slice.columns) * static_cast<std::size_t>(slice.rows));
  for (int row = 0; row < slice.rows; ++row)
    for (int column = 0; column < slice.columns; ++column) {
      Vec3 q = picture.through;
      q[slice.u] =
          std::min(picture.box.low[slice.u] + (column + 0.5) * slice.pixel, picture.box.high[slice.u]);
      q[slice.v] = std::min(picture.box.low[slice.v] + (row + 0.5) * slice.pixel, picture.box.high[slice.v]);
      slice.label[static_cast<std::size_t>(row * slice.columns + column)] = picture.label(q);
    }
  for (const Vec3& state : picture.states)
    if (std::abs(state[normal] - picture.through[normal]) <= 0.5 * picture.spacing &&
        picture.box.contains(state))
      slice.states.emplace_back(state[slice.u], state[slice.v]);
  slice.too_many_states = slice.states.size() > most_states;
  if (slice.too_many_states) slice.states.clear();
  cut_body(picture, slice);
  return slice;
}

}  // namespace forefeel
