#include "apps/picture/coverage_slice.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace forefeel {
namespace {

constexpr std::size_t most_states = 6000;  // more would hide the colours

// The part of a line inside [0, width] x [0, height]; nothing outside.
std::optional<std::array<Eigen::Vector2d, 2>> clipped(const std::array<Eigen::Vector2d, 2>& line,
                                                      const Eigen::Vector2d& size) {
  const Eigen::Vector2d a = line[0], d = line[1] - line[0];
  double from = 0, to = 1;
  for (int axis = 0; axis < 2; ++axis) {
    if (d[axis] == 0) {
      if (a[axis] < 0 || a[axis] > size[axis]) return {};
      continue;
    }
    const double one = -a[axis] / d[axis], two = (size[axis] - a[axis]) / d[axis];
    from = std::max(from, std::min(one, two));
    to = std::min(to, std::max(one, two));
  }
  if (from >= to) return {};
  return std::array<Eigen::Vector2d, 2>{Eigen::Vector2d(a + from * d), Eigen::Vector2d(a + to * d)};
}

// place(p): the position of p in the slice.
template <class Place>
void cut_body(const CoveragePicture& picture, const Place& place, Slice& slice) {
  const double level = picture.through[slice.normal];
  for (const auto& triangle : picture.body) {
    std::vector<Eigen::Vector2d> crossing;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 &a = triangle[i], &b = triangle[(i + 1) % 3];
      const double da = a[slice.normal] - level, db = b[slice.normal] - level;
      if ((da < 0) == (db < 0)) continue;
      crossing.push_back(place(a + (b - a) * (da / (da - db))));
    }
    if (crossing.size() != 2) continue;
    if (const auto part = clipped({crossing[0], crossing[1]}, {slice.labels.columns, slice.labels.rows}))
      slice.outline.push_back(*part);
  }
}

}  // namespace

Slice cut(const CoveragePicture& picture, int normal) {
  const int u = normal == 0 ? 1 : 0, v = normal == 2 ? 1 : 2;
  const Box& box = picture.box;
  const double width = std::max(box.size()[u], picture.spacing),
               height = std::max(box.size()[v], picture.spacing);
  const double pixel = std::max(picture.spacing / 8, std::max(width, height) / slice_panel);
  const auto samples = [&](double side) {
    return std::max(1, static_cast<int>(std::ceil(side / pixel - 1e-6)));
  };
  const auto label_at = [&](int column, int row) {
    Vec3 q = picture.through;
    q[u] = std::min(box.low[u] + (column + 0.5) * pixel, box.high[u]);
    q[v] = std::min(box.low[v] + (row + 0.5) * pixel, box.high[v]);
    return picture.label(q);
  };
  const auto place = [&](const Vec3& p) {
    return Eigen::Vector2d((p[u] - box.low[u]) / pixel, (p[v] - box.low[v]) / pixel);
  };
  Slice slice{.normal = normal,
              .u = u,
              .v = v,
              .labels = LabelImage(samples(width), samples(height), label_at),
              .states = {},
              .outline = {},
              .state_radius = 0.09 * picture.spacing / pixel};
  for (const Vec3& state : picture.states)
    if (std::abs(state[normal] - picture.through[normal]) <= 0.5 * picture.spacing && box.contains(state))
      slice.states.push_back(place(state));
  slice.too_many_states = slice.states.size() > most_states;
  if (slice.too_many_states) slice.states.clear();
  cut_body(picture, place, slice);
  return slice;
}

}  // namespace forefeel
