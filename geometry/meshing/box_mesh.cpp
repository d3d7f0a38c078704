#include "geometry/meshing/box_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/common/error.hpp"

namespace forefeel {
bool within_share(std::size_t count, std::size_t asked) {
  return std::abs(static_cast<double>(count) - static_cast<double>(asked)) <
         0.0499 * static_cast<double>(asked);
}

TetMesh box_mesh(const Box& box, const std::array<int, 3>& cells) {
  TetMesh mesh;
  const auto at = [&](int i, int j, int k) {
    return static_cast<NodeIndex>((k * (cells[1] + 1) + j) * (cells[0] + 1) + i);
  };
  for (int k = 0; k <= cells[2]; ++k)
    for (int j = 0; j <= cells[1]; ++j)
      for (int i = 0; i <= cells[0]; ++i)
        mesh.nodes.emplace_back(
            box.low +
            Vec3(double(i) / cells[0], double(j) / cells[1], double(k) / cells[2]).cwiseProduct(box.size()));
  constexpr unsigned orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                     {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};  // first three even
  for (int k = 0; k < cells[2]; ++k)
    for (int j = 0; j < cells[1]; ++j)
      for (int i = 0; i < cells[0]; ++i)
        for (int o = 0; o < 6; ++o) {
          std::array<int, 3> corner{i, j, k};
          Tet tet{at(i, j, k), 0, 0, 0};
          for (unsigned s = 0; s < 3; ++s) {
            ++corner[orders[o][s]];
            tet[s + 1] = at(corner[0], corner[1], corner[2]);
          }
          if (o >= 3) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
        }
  return mesh;
}

std::array<int, 3> cells_for(const Vec3& size, std::size_t elements) {
  const double cells = static_cast<double>(elements) / 6;
  const double edge = std::cbrt(size.prod() / cells);
  std::array<int, 3> best{};
  double least = 1e300;
  const auto reach = [&](int axis) { return static_cast<int>(2 * size[axis] / edge) + 2; };
  for (int i = 1; i <= reach(0); ++i)
    for (int j = 1; j <= reach(1); ++j) {
      const int k = std::max(1, static_cast<int>(std::lround(cells / i / j)));
      const auto count = static_cast<std::size_t>(6) * static_cast<std::size_t>(i) *
                         static_cast<std::size_t>(j) * static_cast<std::size_t>(k);
      if (!within_share(count, elements)) continue;
      const Vec3 sides(size.x() / i, size.y() / j, size.z() / k);
      // Cost of aspect ratio and count: a deviation of 2 % in the count weighs as much as an elongation of 2 %.
      const double cost =
          sides.maxCoeff() / sides.minCoeff() + std::abs(static_cast<double>(count) / (6 * cells) - 1);
      if (cost < least) least = cost, best = {i, j, k};
    }
  if (best[0] == 0)
    throw InputError(
        "phantom", fmt::format("{} elements cannot be met within 5 % by a grid, expected about {}", elements,
                               6 * std::max(1L, std::lround(cells))));
  return best;
}

Surface box_surface(const Box& box) {
  Surface surface;
  for (unsigned i = 0; i < 8; ++i)
    surface.nodes.emplace_back(i & 1 ? box.high.x() : box.low.x(), i & 2 ? box.high.y() : box.low.y(),
                               i & 4 ? box.high.z() : box.low.z());
  surface.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                       {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return surface;
}

}  // namespace forefeel
