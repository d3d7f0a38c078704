#pragma once
// Fixed directions of view, along which NeighbourSelector looks for the sides of a gap.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel::detail {

// 256 directions, evenly spread over the sphere (spiral of the golden angle), each with its opposite; and for
// each cell of a grid on the faces of a cube those within `turned` (cosine) of some direction in the cell.
class Views {
 public:
  static constexpr double turned =
      0.93;  // cosine within which a state's own view is blended from the fixed ones

  Views();
  // Number of the cell that the direction u lies in; cells x cells on each of the six faces.
  static std::size_t cell_of(const Vec3& u, int cells);
  // Numbers of the directions about u.
  std::span<const std::uint16_t> of(const Vec3& u) const;

  std::vector<Vec3> all;

 private:
  static constexpr int pairs = 128, grid = 16;
  std::vector<std::uint16_t> about_;
  std::vector<std::size_t> first_;  // in about_, of each cell
};

const Views& views();

}  // namespace forefeel::detail
